"""The synthetic reference flight: firn physics and a radar, no code of what is scored on it."""

from snowsim.reference.settings import Settings, checked_settings

__all__ = [
    "Settings",
    "checked_settings",
    "draw_climate",
    "draw_complex_segment",
    "draw_frame",
    "draw_scene",
]


def __getattr__(name):
    """Functions that draw, imported at first use: starts of the workflow only check settings."""
    if name == "draw_climate":
        from snowsim.reference.climate import draw_climate as found
    elif name == "draw_complex_segment":
        from snowsim.reference.flight import draw_complex_segment as found
    elif name == "draw_frame":
        from snowsim.reference.flight import draw_frame as found
    elif name == "draw_scene":
        from snowsim.reference.benchmark import draw_scene as found
    else:
        msg = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(msg)
    return found
