"""The synthetic reference flight: firn physics and a radar that share no equation with the renderers it judges."""

from snowsim.reference.benchmark import draw_scene
from snowsim.reference.climate import draw_climate
from snowsim.reference.flight import draw_complex_segment, draw_frame
from snowsim.reference.settings import Settings, checked_settings

__all__ = ["Settings", "checked_settings", "draw_climate", "draw_complex_segment", "draw_frame", "draw_scene"]
