"""Frames with made-up times and positions around given power and layers."""

import numpy as np

from lib.placeholder_frames import placeholder_frame

BIN_S = 2.886e-10
FIRST_TWTT_S = 3e-6
DEGREES_PER_LINE = 4.92e-5  # 5.47 m on a sphere of 6371 km


def made_up_frame(power, layer_bins, *, minute=0, bin_s=BIN_S):
    """Echogram and layers whose record begins at `FIRST_TWTT_S`."""
    latitude = 70 + DEGREES_PER_LINE * np.arange(power.shape[1])
    echogram, layers = placeholder_frame(power, layer_bins, latitude, bin_s=bin_s, minute=minute)
    echogram = echogram.assign_coords(twtt=FIRST_TWTT_S + echogram["twtt"])
    echogram["Surface"] = FIRST_TWTT_S + echogram["Surface"]
    return echogram, layers.assign(twtt=FIRST_TWTT_S + layers["twtt"])
