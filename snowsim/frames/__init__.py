"""Observed frames made comparable: layers on its lines, unfit lines left out, one bin size, level, blocks of 256."""

from snowsim.frames.blocks import cut_blocks, frame_of_scene
from snowsim.frames.flatten import align_layers, flatten, resample_range
from snowsim.frames.unfit import UNFIT_FLAGS, count_unfit, leave_out_unfit

__all__ = [
    "UNFIT_FLAGS",
    "align_layers",
    "count_unfit",
    "cut_blocks",
    "flatten",
    "frame_of_scene",
    "leave_out_unfit",
    "resample_range",
]
