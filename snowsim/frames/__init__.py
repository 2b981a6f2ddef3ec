"""Observed frames made comparable.

Layers on its lines, flagged lines left out, one bin size, level, blocks of 256.
"""

from snowsim.frames.blocks import cut_blocks, frame_of_scene
from snowsim.frames.flatten import (
    FLAGGED_BY,
    align_layers,
    count_flagged,
    flatten,
    leave_out_flagged,
    resample_range,
)

__all__ = [
    "FLAGGED_BY",
    "align_layers",
    "count_flagged",
    "cut_blocks",
    "flatten",
    "frame_of_scene",
    "leave_out_flagged",
    "resample_range",
]
