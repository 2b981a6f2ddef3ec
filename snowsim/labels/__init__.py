"""Synthetic layer geometries drawn from flight statistics."""

from snowsim.labels.draw import draw, draw_scene
from snowsim.labels.nonstationary import Beyond
from snowsim.labels.prepare import LabelModel, prepare

__all__ = ["Beyond", "LabelModel", "draw", "draw_scene", "prepare"]
