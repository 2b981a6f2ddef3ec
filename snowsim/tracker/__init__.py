"""The layer tracker: network and training, and the way from an echogram to its layers.

Names are loaded when asked for, so that tracking needs no torch, and training no onnxruntime.
"""

import importlib

from snowsim.constants import OUTPUTS
from snowsim.settings import TrackerSettings as Settings
from snowsim.settings import published_settings

# Names of the package, by the module they are in.
MODULES = {
    "calibration": (
        "WITHIN_BINS",
        "Calibration",
        "Ridges",
        "calibrate",
        "edge_counts",
        "fit_logistic",
        "near_a_layer",
        "reliability",
        "ridges_of",
    ),
    "card": ("CONFIDENCE", "Card", "checked_card", "make_card"),
    "inputs": ("canonical",),
    "joining": ("join",),
    "layers": ("between_lines", "confidence", "features", "half_width_rows", "on_lines"),
    "linking": ("Candidates", "Linking", "Piece", "find_candidates", "link"),
    "network": ("MultiScaleNetwork", "balanced_cross_entropy", "fused_logits", "track"),
    "picks": (
        "deepest_row",
        "evidence_of",
        "layers_of_frames",
        "pick_layers",
        "pieces_in",
        "probability_of",
        "rows_in_image",
        "rows_of",
    ),
    "portable": ("network_of_onnx", "to_onnx"),
    "published": ("PublishedNetwork",),
    "sampling": ("Completed", "TrainingSet", "copy_shown"),
    "train": ("Training", "rate_factor", "train_steps", "trained_network"),
    "windows": ("log_odds_by_lines", "runner"),
}

__all__ = [
    "OUTPUTS",
    "Settings",
    "published_settings",
    *(name for names in MODULES.values() for name in names),
]


def __getattr__(name):
    """A name of `MODULES`."""
    for module, names in MODULES.items():
        if name in names:
            return getattr(importlib.import_module(f"{__name__}.{module}"), name)
    msg = f"module {__name__!r} has no attribute {name!r}"
    raise AttributeError(msg)
