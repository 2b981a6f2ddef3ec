"""One scene of a sweep, the ways it is computed, and the outcome of each by an unrelated quadrature."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from lib.diagnostics import phy_alternatives as ways
from lib.diagnostics.phy_errors import largest_error_db
from snowsim.phy.parameters import checked_waveforms
from snowsim.phy.power import mean_power

EXACT_LIMIT_DB = (
    1e-11  # closed form and quadrature lose 5e-13 each where exponents are large: 4e-12 dB
)
SHORTCUT_LIMIT_DB = 0.5  # the speckle of 100 looks is 0.43 dB
MOST_ROWS_COMPARED = 10_000
REACH_DEVIATIONS = 9.5  # beyond, a Gaussian is below 3e-20 of its peak
REACH_DECAYS = 45  # beyond, an exponential is
CHUNK = 20_000
NODES, WEIGHTS = np.polynomial.legendre.leggauss(128)


@dataclass(frozen=True)
class Case:
    """One scene as `mean_power` is given it, with noise and tolerance.

    As printed (``normalise="none", align="gaussian"``), so that the outcome does not rest on where
    a peak was found.
    """

    layer_bins: np.ndarray
    peak_power: np.ndarray
    variance_bins2: np.ndarray
    decay_rate: np.ndarray
    n_range_bins: int = 256
    noise_power: float = 1e-3
    tolerance_db: float = 0.05

    @property
    def given(self):
        """Arguments of `mean_power`."""
        names = ("layer_bins", "peak_power", "variance_bins2", "decay_rate", "n_range_bins")
        return {name: getattr(self, name) for name in names} | {
            "normalise": "none",
            "align": "gaussian",
        }

    def computed(self, method):
        """Mean power by a method, (range_bin, range_line); ValueError where it is refused."""
        tolerance = {"tolerance_db": self.tolerance_db, "noise_power": self.noise_power}
        if method == "exact":
            return mean_power(**self.given)
        if method == "planned":
            return mean_power(**self.given, **tolerance)
        if method in ("recursive32", "recursive64"):
            return ways.recursive_power(
                self.waveforms(), **tolerance, dtype=method.replace("recursive", "float")
            )
        if method == "table32":
            return ways.single_precision_power(self.waveforms(), **tolerance)
        way = {
            "sampled": ways.convolved_power,
            "naive": ways.naive_power,
            "wrapped": ways.wrapped_power,
        }
        way |= {"cut": ways.cut_power, "nearest": ways.nearest_power}
        return way[method](self.waveforms())

    def outcome(self, method):
        """Outcome of a method: the exact form is held to a relative error, others to that of power plus noise."""
        limits_db = {
            "exact": EXACT_LIMIT_DB,
            "planned": self.tolerance_db,
            "table32": self.tolerance_db,
        }

        def error_db(power):
            rows = np.linspace(
                0, self.n_range_bins - 1, min(self.n_range_bins, MOST_ROWS_COMPARED)
            ).astype(int)
            noise_power = 0.0 if method == "exact" else self.noise_power
            return largest_error_db(
                power[rows], quadrature_power(self.waveforms(), rows), noise_power
            )

        return outcome_of(
            partial(self.computed, method), error_db, limits_db.get(method, SHORTCUT_LIMIT_DB)
        )

    def waveforms(self):
        """The same, checked."""
        return checked_waveforms(**self.given)


@np.errstate(all="ignore")
def outcome_of(work, error_of, limit_db):
    """Error [dB], limit [dB] and outcome of a power that is computed; refusing is no error."""
    try:
        power = work()
    except ValueError:
        return np.nan, limit_db, "refused"
    error_db = error_of(power)
    return error_db, limit_db, outcome(error_db, limit_db)


def outcome(error_db, limit_db):
    """``within`` where the error is at most the limit, else ``wrong``."""
    return "within" if error_db <= limit_db else "wrong"


def row(setting, value, method, found):
    """One row of the atlas; errors keep three digits, the rest is rounding that differs between machines."""
    error_db, limit_db, result = found
    about = {"setting": setting, "value": value, "method": method}
    return about | {"error_db": float(f"{error_db:.3g}"), "limit_db": limit_db, "outcome": result}


def compared(setting, values, case_of, methods):
    """Rows of one sweep: the case of every value by `exact`, `planned` and every further method."""
    cases = [(value, case_of(value)) for value in values]
    methods = ("exact", "planned", *methods)
    return [
        row(setting, value, method, case.outcome(method))
        for value, case in cases
        for method in methods
    ]


def noisy(case, relative_noise=1e-3):
    """The same scene with noise relative to the peak of its weakest layer."""
    return replace(case, noise_power=float(relative_noise * case.waveforms().peak_power.min()))


def quadrature_power(waveforms, rows):
    """Mean power on some rows by quadrature, float64 (row, range_line)."""
    return ways.summed_power(waveforms, waveform_by_quadrature, rows)


def waveform_by_quadrature(x_bins, variance_bins2, decay_rate):
    """Waveform of one layer, ``int_0^inf exp(-(x - t)^2 / 2d - a t) dt``, float64 of the shape of `x_bins`.

    Gauss-Legendre over where the integrand exceeds 1e-19 of its largest value: all terms are
    positive, none cancel.
    """
    x_bins = np.asarray(x_bins, dtype=float)
    flat = x_bins.ravel()
    chunks = [
        _integral(flat[i : i + CHUNK], variance_bins2, decay_rate)
        for i in range(0, flat.size, CHUNK)
    ]
    return np.concatenate([np.empty(0), *chunks]).reshape(x_bins.shape)


@np.errstate(under="ignore", over="ignore")
def _integral(x, variance, decay):
    """Over u = t - t0, t0 >= 0 where the integrand is largest: there ``x - t0 = min(a d, x)``, and nothing cancels."""
    reach = REACH_DEVIATIONS * np.sqrt(variance)
    largest_at = np.maximum(x - decay * variance, 0)
    largest = -(np.minimum(decay * variance, x) ** 2) / (2 * variance) - decay * largest_at
    slope = np.maximum(decay - x / variance, 0)  # where t0 = 0, how fast the integrand falls
    start = -np.minimum(largest_at, reach)
    stop = np.minimum(reach, REACH_DECAYS / np.maximum(slope, 1e-300))
    half = (stop - start)[:, None] / 2
    u = start[:, None] + half * (1 + NODES)
    exponent = largest[:, None] - slope[:, None] * u - u**2 / (2 * variance)
    return (half * WEIGHTS * np.exp(exponent)).sum(axis=1)
