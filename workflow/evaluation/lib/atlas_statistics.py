"""Where the estimators fail: flights planted with eq. (1), until what was planted is lost.

A row has the mean `error` over layers, its `largest` magnitude, and of a flight that is refused the
line that says so, as `note`. ``beyond`` is further off than the quantity's bound; ``not finite``
must not be.
"""

import warnings
from dataclasses import dataclass

import numpy as np
import pandas as pd

from lib.placeholder_frames import placeholder_frame
from snowsim.constants import EARTH_RADIUS_M
from snowsim.phy import mean_power
from snowsim.phy.waveform import waveform_width
from snowsim.statistics import ESTIMATORS, estimate, merge, summarise
from snowsim.statistics.summaries import GROUP_LINES

PEAK_POWER = np.array([1.0, 0.3, 0.2, 0.15, 0.1])  # above the noise, by layer
VARIANCE_BINS2 = 12.5  # of the Gaussian of all layers
THICKNESS_SD = 0.05  # of slabs, relative, from group to group of range lines
N_FRAMES = 2
N_GROUPS = 13  # of a frame, just more than a block
SURFACE_BIN = 60.0
BIN_SIZE_S = 2.886e-10
LINE_SPACING_M = 5.47
# Largest error of a quantity, relative or in bins.
BOUNDS = {"peak_power": 0.03, "decay_rate": 0.05, "width_bins": 1.0}
IN_BINS = ("width_bins",)


@dataclass(frozen=True)
class Planted:
    """A flight of five layers of eq. (1), 44 bins apart by default."""

    decay_rate: tuple = (0.09, 0.07, 0.06, 0.06, 0.05)  # per bin, by layer
    noise_power: float = 1e-3
    slab_bins: float = 44.0  # mean thickness of slabs
    n_looks: float = 16  # of a range line

    def truth(self):
        """What is planted, by quantity, each (layer,)."""
        decay_rate = np.array(self.decay_rate)
        return {
            "peak_power": PEAK_POWER,
            "decay_rate": decay_rate,
            "width_bins": waveform_width(VARIANCE_BINS2, decay_rate),
        }

    def frames(self, rng):
        """Pairs of echogram and layers, one at a time; layers are level within a group of lines."""
        n_lines = N_GROUPS * GROUP_LINES
        latitude = 70 + np.degrees(LINE_SPACING_M / EARTH_RADIUS_M) * np.arange(n_lines)
        for index in range(N_FRAMES):
            surface_bins = SURFACE_BIN + rng.uniform(-0.5, 0.5, N_GROUPS)
            spread = rng.standard_normal((PEAK_POWER.size - 1, N_GROUPS))
            slabs = self.slab_bins * np.exp(THICKNESS_SD * spread)
            of_groups = np.cumsum(np.vstack([surface_bins, slabs]), axis=0)
            power = self.noise_power + mean_power(
                of_groups,
                PEAK_POWER,
                np.full(PEAK_POWER.size, VARIANCE_BINS2),
                self.decay_rate,
                n_range_bins=int(of_groups.max()) + 100,
            )
            layer_bins = np.repeat(of_groups, GROUP_LINES, axis=1)
            power = np.repeat(power, GROUP_LINES, axis=1)
            power *= rng.gamma(self.n_looks, 1 / self.n_looks, power.shape)
            yield placeholder_frame(power, layer_bins, latitude, bin_s=BIN_SIZE_S, minute=index)


def weakest_over_noise(ratio_db):
    """The flight whose weakest layer lies so far over the noise."""
    return Planted(noise_power=PEAK_POWER[-1] * 10 ** (-ratio_db / 10))


def alike_in_decay(decay_rate):
    """The flight whose layers all decay at one rate."""
    return Planted(decay_rate=(decay_rate,) * PEAK_POWER.size)


# Values of each sweep, and the flight planted for one.
SWEEPS = {
    "slab thickness [bins]": ((3, 8, 18, 44, 80), lambda bins: Planted(slab_bins=bins)),
    "weakest layer over noise [dB]": ((-10, -5, 0, 10, 20), weakest_over_noise),
    "decay rate [per bin]": ((0.01, 0.03, 0.1, 0.3, 1.0), alike_in_decay),
    "looks of a range line": ((0.2, 1, 4, 16, 100), lambda n: Planted(n_looks=n)),
}


def draw_atlas(stream):
    """Rows of all sweeps as a table; `stream` gives the random generator of a sweep and a value."""
    rows = []
    for sweep, (values, plant) in SWEEPS.items():
        for value in values:
            planted = plant(value)
            frames = planted.frames(stream(sweep, value))
            for row in compared(planted, frames):
                rows.append({"sweep": sweep, "value": float(value), **row})
    return pd.DataFrame(rows)


def compared(planted, frames):
    """Rows of one flight by every estimator."""
    rows = []
    summary = merge(summarise(*frame) for frame in frames)
    for estimator in ESTIMATORS:
        try:
            with warnings.catch_warnings():
                # That a flight stands on little: so short a one is meant to.
                warnings.simplefilter("ignore", UserWarning)
                fitted = estimate(summary, estimator=estimator)
        except ValueError as error:
            row = {"quantity": "all", "outcome": "refused", "note": str(error)}
            rows.append({"estimator": estimator, **row})
            continue
        if not is_finite(fitted):
            rows.append({"estimator": estimator, "quantity": "all", "outcome": "not finite"})
            continue
        for quantity, true in planted.truth().items():
            rows.append({"estimator": estimator, **_compared(fitted, quantity, true)})
    return rows


def is_finite(fitted):
    """Whether every number is finite but the decay rate of the deepest layer in `paper`."""
    is_paper = fitted.attrs["estimator"] == "paper"
    for name, variable in fitted.variables.items():
        has_deepest = not (is_paper and name.startswith("decay_rate"))
        values = variable.values if has_deepest else variable.values[:-1]
        if not np.isfinite(values).all():
            return False
    numbers = [value for value in fitted.attrs.values() if not isinstance(value, str)]
    return all(map(np.isfinite, numbers))


def _compared(fitted, quantity, true):
    """Error of one quantity over the layers that were found; three digits, the rest is noise."""
    found = fitted[quantity].values
    known = np.flatnonzero(np.isfinite(found))
    scale = 1.0 if quantity in IN_BINS else true[known]
    error = (found[known] - true[known]) / scale
    bound = BOUNDS[quantity]
    within = np.abs(error) <= bound
    return {
        "quantity": quantity,
        "error": _rounded(error.mean()),
        "largest": _rounded(np.abs(error).max()),
        "bound": bound,
        "outcome": "within" if within.all() else "beyond",
    }


def _rounded(number):
    return float(f"{number:.3g}")
