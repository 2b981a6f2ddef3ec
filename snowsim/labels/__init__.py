"""Synthetic layer geometries drawn from flight statistics, and the echoes of their layers."""

from snowsim.labels.echoes import echoes_of_layers, with_waveforms_of
from snowsim.labels.paper import draw_paper_scene, echoes_of_layers_as_printed
from snowsim.labels.scene import LabelModel, draw, draw_scene, prepare
from snowsim.labels.undulations import Nonstationary

__all__ = [
    "LabelModel",
    "Nonstationary",
    "draw",
    "draw_paper_scene",
    "draw_scene",
    "echoes_of_layers",
    "echoes_of_layers_as_printed",
    "prepare",
    "with_waveforms_of",
]
