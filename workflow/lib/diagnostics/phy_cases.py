"""One scene of a sweep, the ways it is computed, and the verdict on each."""

from dataclasses import dataclass, replace

import numpy as np

from lib.diagnostics import phy_alternatives as shortcuts
from lib.diagnostics.phy_alternatives import convolved_power, mean_power_by, quadrature_power
from lib.diagnostics.phy_errors import largest_error_db
from snowsim.phy.parameters import checked_waveforms
from snowsim.phy.power import mean_power
from snowsim.phy.tables import LARGEST_ERROR

# Closed form and quadrature lose some 5e-13 each where exponents are large: 4e-12 dB.
EXACT_LIMIT_DB = 1e-11
# What shortcuts are held to: the speckle of 100 looks is 0.43 dB.
SHORTCUT_LIMIT_DB = 0.5
MOST_ROWS_JUDGED = 10_000


@dataclass(frozen=True)
class Case:
    """One scene as `mean_power` is given it, with noise and tolerance.

    As printed (``normalise="none", align="gaussian"``), so that the verdict does not rest on where a peak was found.
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
        return {name: getattr(self, name) for name in names} | {"normalise": "none", "align": "gaussian"}

    def computed(self, method):
        """Mean power by a method, (range_bin, range_line); ValueError where it is refused."""
        tolerance = {"tolerance_db": self.tolerance_db, "noise_power": self.noise_power}
        if method == "exact":
            return mean_power(**self.given)
        if method == "planned":
            return mean_power(**self.given, **tolerance)
        if method in ("recursive32", "recursive64"):
            dtype = {"recursive32": np.float32, "recursive64": np.float64}[method]
            return mean_power_by("recursive", **self.given, **tolerance, dtype=dtype)
        if method == "table32":
            error = min(1 - 10 ** (-self.tolerance_db / 10), LARGEST_ERROR)
            return shortcuts.single_precision_power(self.waveforms(), self.noise_power, error)
        way = {"sampled": convolved_power, "naive": shortcuts.naive_power, "wrapped": shortcuts.wrapped_power}
        way |= {"cut": shortcuts.cut_power, "nearest": shortcuts.nearest_power}
        return way[method](self.waveforms())

    def verdict(self, method):
        """Error [dB], limit [dB] and outcome of a method.

        The exact form is held to a relative error, others to that of power plus noise; refusing is no error.
        """
        limits_db = {"exact": EXACT_LIMIT_DB, "planned": self.tolerance_db, "table32": self.tolerance_db}
        limit_db = limits_db.get(method, SHORTCUT_LIMIT_DB)
        with np.errstate(all="ignore"):
            try:
                power = self.computed(method)
            except ValueError:
                return np.nan, limit_db, "refused"
            n_judged = min(self.n_range_bins, MOST_ROWS_JUDGED)
            rows = np.linspace(0, self.n_range_bins - 1, n_judged).astype(int)
            noise_power = 0.0 if method == "exact" else self.noise_power
            error_db = largest_error_db(power[rows], quadrature_power(self.waveforms(), rows), noise_power)
        return error_db, limit_db, outcome(error_db, limit_db)

    def waveforms(self):
        """The same, checked."""
        return checked_waveforms(**self.given)


def outcome(error_db, limit_db):
    """``within`` where the error is at most the limit, else ``wrong``."""
    return "within" if error_db <= limit_db else "wrong"


def row(setting, value, method, verdict):
    """One row of the atlas; errors keep three digits, the rest is rounding that differs between machines."""
    error_db, limit_db, result = verdict
    return {
        "setting": setting,
        "value": value,
        "method": method,
        "error_db": float(f"{error_db:.3g}"),
        "limit_db": limit_db,
        "outcome": result,
    }


def judged(setting, cases, methods):
    """Rows of one sweep: every case, (value, Case) pairs, by `exact`, `planned` and every further method."""
    return [
        row(setting, value, method, case.verdict(method))
        for value, case in cases
        for method in ("exact", "planned", *methods)
    ]


def noisy(case, relative_noise=1e-3):
    """The same scene with noise relative to the peak of its weakest layer."""
    return replace(case, noise_power=float(relative_noise * case.waveforms().peak_power.min()))
