"""Layer tracker: its networks, their training, and the picking of layers in echograms.

Names are loaded on first use, so that tracking needs no torch, and training no onnxruntime.
"""

import lazy_loader

from snowsim.constants import OUTPUTS
from snowsim.settings import TrackerSettings as Settings
from snowsim.settings import published_settings

# Names of the package by module.
MODULES = {
    "calibration": (
        "WITHIN_BINS",
        "Calibration",
        "Ridges",
        "calibrate",
        "edge_counts",
        "fit_logistic",
        "fit_logits",
        "near_a_layer",
        "reliability",
        "ridges_of",
    ),
    "card": ("CONFIDENCE", "Card", "checked_card", "make_card"),
    "inputs": ("Canonical", "Grid", "canonical"),
    "joining": ("join",),
    "layers": (
        "between_lines",
        "confidence",
        "confident_pieces",
        "features",
        "half_width_rows",
        "on_lines",
    ),
    "linking": ("Candidates", "Linking", "Piece", "find_candidates", "link"),
    "network": (
        "MultiScaleNetwork",
        "PyramidNetwork",
        "balanced_cross_entropy",
        "fused_logits",
        "logits_of",
        "track",
    ),
    "picks": (
        "Evidence",
        "deepest_row",
        "evidence_of",
        "layers_of_frames",
        "pick_layers",
        "pieces_in",
        "probability_of",
        "rows_in_image",
    ),
    "portable": ("network_of_onnx", "to_onnx"),
    "published": ("PublishedNetwork",),
    "sampling": ("Completed", "TrainingSet", "copy_shown"),
    "train": ("Training", "rate_factor", "train_steps", "trained_network"),
    "windows": ("log_odds_by_lines", "runner", "stretches"),
}

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submod_attrs=MODULES)
__all__ += ["OUTPUTS", "Settings", "published_settings"]
