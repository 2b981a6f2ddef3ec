"""Snow as its users know it: density and depth, what a radar sees of them, accumulation."""

import importlib

# Functions and classes by their module, loaded at first use: who checks settings needs firn alone.
FACE = {"accumulation": "snow"} | dict.fromkeys(("by_year", "pieces", "table"), "tables")
FACE |= dict.fromkeys(("Climate", "PRESETS", "Radar", "Snowpack"), "physical")
FACE |= {"physical_parameters": "physical", "simulate": "simulation"}
FACE |= dict.fromkeys(("Reflectors", "combine"), "profile")

__all__ = sorted(FACE)


def __getattr__(name):
    """A name of `FACE`."""
    if name not in FACE:
        msg = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(msg)
    return getattr(importlib.import_module(f"{__name__}.{FACE[name]}"), name)
