"""Synthetic layer geometries drawn from flight statistics."""

from snowsim.labels.draw import draw, draw_scene
from snowsim.labels.prepare import LabelModel, prepare
from snowsim.labels.process import Beyond

__all__ = ["Beyond", "LabelModel", "draw", "draw_scene", "prepare"]
