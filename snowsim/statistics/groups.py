"""Averaged range lines with layers, and what both estimators assume of them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

OPEN_END_BINS = 40  # a line with a single layer ends this far below its pick
TYPICAL_DECAY_RATE = 0.1  # [per bin] of a waveform, where none was measured


@dataclass(frozen=True)
class Groups:
    """Averaged range lines of a flight with the layers in them."""

    # Power (group, row): the first row is `FIRST_ROW` below the surface; NaN outside the record.
    power: np.ndarray
    # A part (group, layer, part) is one of equal shares of a layer's picks in order of depth.
    position: np.ndarray  # mean row of a part, NaN where the layer is absent
    spread: np.ndarray  # variance of the rows in a part [bins^2]
    present: np.ndarray  # (group, layer), bool
    noise_power: float

    @cached_property
    def row(self):
        """Mean row of a layer, (group, layer)."""
        return self.position.mean(axis=2)


def powers_of_all_layers(values, known):
    """Powers by layer; unknown ones are interpolated between neighbours, in the logarithm."""
    logarithm = pd.Series(np.log(np.where(known, values, np.nan)))
    return np.exp(logarithm.interpolate(limit_direction="both").to_numpy())
