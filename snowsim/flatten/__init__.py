"""Observed frames made comparable: layers on the echogram's lines, one bin size, a level surface, blocks of 256."""

from snowsim.flatten.align import align_layers
from snowsim.flatten.blocks import cut_blocks, frame_of_scene
from snowsim.flatten.level import flatten
from snowsim.flatten.resample import resample_range

__all__ = ["align_layers", "cut_blocks", "flatten", "frame_of_scene", "resample_range"]
