"""Simulation of airborne Snow Radar echograms, and what it does for tracking annual snow layers."""

import lazy_loader

__version__ = "0.5.0"

# What people script with, by the module it is in; loaded when asked for, so that importing the
# package imports nothing.
FRONT = {
    "front": ["scenes"],
    "scoring": ["score_folders"],
    "snowpack": ["Climate", "Radar", "Snowpack", "accumulation", "simulate"],
    "tracking": ["Tracker", "list_pretrained"],
}
__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submod_attrs=FRONT)
