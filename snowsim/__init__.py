"""Simulation of airborne Snow Radar echograms, and what it does for tracking annual snow layers."""

import importlib

__version__ = "0.4.0"

# What people script with, by the module it is in; loaded when asked for, so that importing the
# package imports nothing.
FRONT = {"scenes": "snowsim.front", "score_folders": "snowsim.scoring"}
FRONT |= dict.fromkeys(
    ("Climate", "Radar", "Snowpack", "accumulation", "simulate"), "snowsim.snowpack"
)
FRONT |= dict.fromkeys(("Tracker", "list_pretrained"), "snowsim.tracking")

__all__ = sorted(FRONT)


def __getattr__(name):
    """A name of `FRONT`."""
    if name not in FRONT:
        msg = f"module 'snowsim' has no attribute {name!r}"
        raise AttributeError(msg)
    return getattr(importlib.import_module(FRONT[name]), name)


def __dir__():
    return sorted({*globals(), *FRONT})
