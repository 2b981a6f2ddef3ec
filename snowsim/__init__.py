"""Simulation of airborne Snow Radar echograms, and what it does for tracking annual snow layers."""

import importlib

__version__ = "0.1.0"
FRONT = ("Climate", "Radar", "Snowpack", "scenes", "simulate")


def __getattr__(name):
    # Imported when asked for: jobs that need one stage do not wait for the others.
    if name not in FRONT:
        msg = f"module 'snowsim' has no attribute {name!r}"
        raise AttributeError(msg)
    return getattr(importlib.import_module("snowsim.front"), name)
