"""The synthetic reference flight: firn physics and a radar, which share no code with PHY."""

import importlib

from reference.settings import Settings, checked_settings

# Functions that draw, by their module. They are loaded at first use, since starting the workflow
# only checks settings.
DRAWING = {
    "draw_climate": "climate",
    "draw_complex_segment": "flight",
    "draw_frame": "flight",
    "draw_scene": "benchmark",
}

__all__ = [
    "Settings",
    "checked_settings",
    "draw_climate",
    "draw_complex_segment",
    "draw_frame",
    "draw_scene",
]


def __getattr__(name):
    """A function of `DRAWING`."""
    if name not in DRAWING:
        msg = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(msg)
    return getattr(importlib.import_module(f"{__name__}.{DRAWING[name]}"), name)
