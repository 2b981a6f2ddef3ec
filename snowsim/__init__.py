"""Simulation of airborne Snow Radar echograms, and what it does for tracking annual snow layers."""

__version__ = "0.1.0"
