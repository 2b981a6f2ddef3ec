"""The physics of one scene in a record: what PHY needs to know of each echo, and of the radar."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np


class Kind(IntEnum):
    """What an echo comes from."""

    LAYER = 0  # labelled
    BACKGROUND = 1  # snow between layers: no layer, an exponential that starts at the surface
    BELOW = 2  # an echo below the last layer, in no label


@dataclass(frozen=True, eq=False)
class Echoes:
    """Echoes of a scene from the surface down, each a term of eq. (1), and how radar sees them.

    Attributes
    ----------
    bins : ndarray, (row, range_line)
        Where each echo's waveform peaks [range bins]; NaN where it is absent.
    power : ndarray, (row, range_line)
        Its linear power there.
    variance_bins2, decay_rate : ndarray, (row,)
        Of its waveform [bins^2, per bin].
    kind : ndarray of int8, (row,)
        One of `Kind`.
    noise_power : float
        Linear.
    n_looks : float
        Independent looks averaged in a pixel.
    speckle_correlation : ndarray, (lag,), or None
        Autocorrelation of speckle down range; None where range bins are independent.
    line_gain_spread_db : float
        Standard deviation of gain from range line to range line [dB].
    decay_factor : float
        By how much decay in this scene differs from the flight's; `decay_rate` includes it.
    """

    bins: np.ndarray
    power: np.ndarray
    variance_bins2: np.ndarray
    decay_rate: np.ndarray
    kind: np.ndarray
    noise_power: float
    n_looks: float
    speckle_correlation: np.ndarray | None = None
    line_gain_spread_db: float = 0.0
    decay_factor: float = 1.0

    def parameters(self):
        """The same as `parameters` of `snowsim.phy.render`."""
        return {
            "peak_power": self.power,
            "variance_bins2": self.variance_bins2,
            "decay_rate": self.decay_rate,
            "noise_power": self.noise_power,
            "n_looks": self.n_looks,
            "speckle_correlation": self.speckle_correlation,
            "line_gain_spread_db": self.line_gain_spread_db,
        }
