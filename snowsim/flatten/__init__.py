"""Observed frames made comparable: layers on its lines, unfit lines left out, one bin size, level, blocks of 256."""

from snowsim.flatten.align import align_layers
from snowsim.flatten.blocks import cut_blocks, frame_of_scene
from snowsim.flatten.level import flatten
from snowsim.flatten.resample import resample_range
from snowsim.flatten.unfit import UNFIT_FLAGS, count_unfit, leave_out_unfit

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
