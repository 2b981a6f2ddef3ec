"""One scene of a sweep, the ways it is computed, and the outcome of each by a quadrature."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from evaluation.lib import phy_alternatives as ways
from evaluation.lib.phy_errors import largest_error_db
from snowsim.phy.parameters import checked_waveforms
from snowsim.phy.power import mean_power

# Closed form and quadrature lose 5e-13 each where exponents are large: 4e-12 dB.
EXACT_LIMIT_DB = 1e-11
SHORTCUT_LIMIT_DB = 0.5  # the speckle of 100 looks is 0.43 dB
MOST_ROWS_COMPARED = 10_000
REACH_DEVIATIONS = 9.5  # beyond, a Gaussian is below 3e-20 of its peak
REACH_DECAYS = 45  # beyond, an exponential is
CHUNK = 20_000
NODES, WEIGHTS = np.polynomial.legendre.leggauss(128)
# As printed, so that the outcome does not rest on where a peak was found.
CONVENTIONS = {"normalise": "none", "align": "gaussian"}
WAYS = {
    "sampled": ways.convolved_power,
    "naive": ways.naive_power,
    "wrapped": ways.wrapped_power,
    "cut": ways.cut_power,
    "nearest": ways.nearest_power,
}
WAYS_WITHIN_TOLERANCE = {
    "recursive32": partial(ways.recursive_power, dtype=np.float32),
    "recursive64": partial(ways.recursive_power, dtype=np.float64),
    "table32": ways.single_precision_power,
}


@dataclass(frozen=True)
class Found:
    """Error of a power [dB], the limit it is held to [dB], and the outcome."""

    error_db: float
    limit_db: float
    outcome: str


@dataclass(frozen=True)
class Case:
    """One scene as `mean_power` is given it, with noise and tolerance."""

    layer_bins: np.ndarray
    peak_power: np.ndarray
    variance_bins2: np.ndarray
    decay_rate: np.ndarray
    n_range_bins: int = 256
    noise_power: float = 1e-3
    tolerance_db: float = 0.05

    @property
    def given(self):
        """Arguments of `mean_power` that make it exact."""
        given = vars(self) | CONVENTIONS
        del given["noise_power"], given["tolerance_db"]
        return given

    def waveforms(self):
        """The same, checked."""
        return checked_waveforms(**self.given)

    def computed(self, method):
        """Mean power by a method, (range_bin, range_line); ValueError where it is refused."""
        tolerance = {"tolerance_db": self.tolerance_db, "noise_power": self.noise_power}
        if method == "exact":
            return mean_power(**self.given)
        if method == "planned":
            return mean_power(**self.given, **tolerance)
        if method in WAYS_WITHIN_TOLERANCE:
            return WAYS_WITHIN_TOLERANCE[method](self.waveforms(), **tolerance)
        return WAYS[method](self.waveforms())

    def found(self, method):
        """What a method comes to.

        The exact form is held to its own error, others to that of power plus noise.
        """
        n_compared = min(self.n_range_bins, MOST_ROWS_COMPARED)
        rows = np.linspace(0, self.n_range_bins - 1, n_compared).astype(int)
        noise_power = 0.0 if method == "exact" else self.noise_power

        def error_db(power):
            exact = quadrature_power(self.waveforms(), rows)
            return largest_error_db(power[rows], exact, noise_power)

        return found_by(partial(self.computed, method), error_db, self.limit_db(method))

    def limit_db(self, method):
        """Largest error that a method may have [dB]."""
        if method == "exact":
            return EXACT_LIMIT_DB
        return self.tolerance_db if method in ("planned", "table32") else SHORTCUT_LIMIT_DB


@np.errstate(all="ignore")
def found_by(work, error_of, limit_db):
    """What a power comes to once it is computed; refusing is no error."""
    try:
        power = work()
    except ValueError:
        return Found(np.nan, limit_db, "refused")
    return held_to(error_of(power), limit_db)


def held_to(error_db, limit_db):
    """``within`` where the error is at most the limit, else ``wrong``."""
    return Found(error_db, limit_db, "within" if error_db <= limit_db else "wrong")


def row(setting, value, method, found):
    """One row of the atlas; errors keep three digits, the rest differs between machines."""
    return {
        "setting": setting,
        "value": value,
        "method": method,
        "error_db": float(f"{found.error_db:.3g}"),
        "limit_db": found.limit_db,
        "outcome": found.outcome,
    }


def noisy(case, relative_noise=1e-3):
    """The same scene with noise relative to the peak of its weakest layer."""
    weakest = case.waveforms().peak_power.min()
    return replace(case, noise_power=float(relative_noise * weakest))


def quadrature_power(waveforms, rows):
    """Mean power on some rows by quadrature, float64 (row, range_line)."""
    return ways.summed_power(waveforms, waveform_by_quadrature, rows)


def waveform_by_quadrature(x_bins, variance_bins2, decay_rate):
    """Waveform of one layer, ``int_0^inf exp(-(x - t)^2 / 2d - a t) dt``, of the shape of `x_bins`.

    Gauss-Legendre over where the integrand exceeds 1e-19 of its largest value: all terms are
    positive, none cancel.
    """
    x_bins = np.asarray(x_bins, dtype=float)
    flat = x_bins.ravel()
    value = np.empty(flat.size)
    for start in range(0, flat.size, CHUNK):
        chunk = slice(start, start + CHUNK)
        value[chunk] = _integral(flat[chunk], variance_bins2, decay_rate)
    return value.reshape(x_bins.shape)


@np.errstate(under="ignore", over="ignore")
def _integral(x, variance, decay):
    """Over u = t - t0, t0 >= 0 where the integrand is largest.

    There ``x - t0 = min(a d, x)``, and nothing cancels.
    """
    reach = REACH_DEVIATIONS * np.sqrt(variance)
    largest_at = np.maximum(x - decay * variance, 0)
    away = np.minimum(decay * variance, x)
    largest = -(away**2) / (2 * variance) - decay * largest_at
    slope = np.maximum(decay - x / variance, 0)  # where t0 = 0, how fast the integrand falls
    start = -np.minimum(largest_at, reach)
    stop = np.minimum(reach, REACH_DECAYS / np.maximum(slope, 1e-300))
    half = (stop - start)[:, None] / 2
    u = start[:, None] + half * (1 + NODES)
    exponent = largest[:, None] - slope[:, None] * u - u**2 / (2 * variance)
    return (half * WEIGHTS * np.exp(exponent)).sum(axis=1)
