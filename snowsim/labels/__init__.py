"""Synthetic layer geometries drawn from flight statistics."""

from snowsim.labels.draw import LabelModel, draw, draw_scene, prepare
from snowsim.labels.nonstationary import Beyond

__all__ = ["Beyond", "LabelModel", "draw", "draw_scene", "prepare"]
