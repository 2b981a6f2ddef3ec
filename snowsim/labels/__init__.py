"""Synthetic layer geometries drawn from flight statistics, and the echoes of their layers."""

from snowsim.labels.draw import check_labels, draw, draw_scene
from snowsim.labels.dress import Dress, dress, redress
from snowsim.labels.prepare import LabelModel, prepare
from snowsim.labels.process import Nonstationary

__all__ = [
    "Dress",
    "LabelModel",
    "Nonstationary",
    "check_labels",
    "draw",
    "draw_scene",
    "dress",
    "prepare",
    "redress",
]
