"""Synthetic layer geometries drawn from flight statistics."""

from snowsim.labels.draw import draw, draw_scene
from snowsim.labels.nonstationary import Nonstationary
from snowsim.labels.prepare import LabelModel, prepare

__all__ = ["LabelModel", "Nonstationary", "draw", "draw_scene", "prepare"]
