"""Synthetic layer geometries drawn from flight statistics."""

from snowsim.labels.beyond import Beyond
from snowsim.labels.draw import LabelModel, draw, draw_scene, prepare
from snowsim.labels.summary import summarise_labels

__all__ = ["Beyond", "LabelModel", "draw", "draw_scene", "prepare", "summarise_labels"]
