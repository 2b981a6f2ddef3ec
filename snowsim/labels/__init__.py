"""Synthetic layer geometries drawn from flight statistics."""

from snowsim.labels.draw import draw, draw_scene
from snowsim.labels.prepare import LabelModel, prepare
from snowsim.labels.process import Nonstationary

__all__ = ["LabelModel", "Nonstationary", "draw", "draw_scene", "prepare"]
