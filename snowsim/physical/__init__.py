"""Radars and snow in physical units, and the terms of eq. (1) that they make."""
