"""Scenes at the borders of what may be given, and beyond: computed right, or refused."""

from dataclasses import replace

import numpy as np

from snowsim.phy.errors import largest_error_db
from snowsim.phy.render import render
from snowsim.phy.stress.judge import outcome, row
from snowsim.phy.stress.power import LINES, PLAIN

SETTING = "borders"
# Speckle of 1e6 looks is 4.3e-3 dB: six deviations are allowed to it.
RENDER_LOOKS, RENDER_SPECKLE_DB = 1e6, 0.03


def border_cases():
    """Scenes that are fine, by name."""
    none, absent = np.empty((0, 4)), np.full((1, 4), np.nan)
    nothing = np.empty(0)
    return {
        "no layers": replace(PLAIN, layer_bins=none, peak_power=nothing, variance_bins2=nothing, decay_rate=nothing),
        "all absent": replace(PLAIN, layer_bins=absent),
        "partly absent": replace(PLAIN, layer_bins=np.where(LINES > 0.5, np.nan, 100 + LINES)),
        "no range lines": replace(PLAIN, layer_bins=np.empty((1, 0))),
        "one pixel": replace(PLAIN, layer_bins=np.zeros((1, 1)), n_range_bins=1),
        "one row": replace(PLAIN, layer_bins=0 * LINES, n_range_bins=1),
        "on top border": replace(PLAIN, layer_bins=0 * LINES),
        "half above top": replace(PLAIN, layer_bins=0 * LINES - 0.5),
        "on bottom border": replace(PLAIN, layer_bins=0 * LINES + 255),
        "half below bottom": replace(PLAIN, layer_bins=0 * LINES + 255.5),
        "no noise": replace(PLAIN, noise_power=0.0),
        "noise over peak": replace(PLAIN, noise_power=1e3),
        "no power": replace(PLAIN, peak_power=np.zeros(1), noise_power=0.0),
        "power of 1e-280": replace(PLAIN, peak_power=np.full(1, 1e-280), noise_power=1e-283),
        "power of 1e300": replace(PLAIN, peak_power=np.full(1, 1e300), noise_power=1e297),
    }


def refused_cases():
    """Scenes that must be refused, by name."""
    return {
        "power NaN": replace(PLAIN, peak_power=np.full(1, np.nan)),
        "power infinite": replace(PLAIN, peak_power=np.full(1, np.inf)),
        "power negative": replace(PLAIN, peak_power=-np.ones(1)),
        "power overflows": replace(PLAIN, peak_power=np.full(1, 1.7e308)),
        "variance zero": replace(PLAIN, variance_bins2=np.zeros(1)),
        "decay negative": replace(PLAIN, decay_rate=-np.ones(1)),
        "position infinite": replace(PLAIN, layer_bins=np.where(LINES > 0.5, np.inf, LINES)),
        "no rows": replace(PLAIN, n_range_bins=0),
        "half a row": replace(PLAIN, n_range_bins=2.5),
        "tolerance zero": replace(PLAIN, tolerance_db=0.0),
        "noise negative": replace(PLAIN, noise_power=-1e-3),
        "layers cross": replace(PLAIN, layer_bins=np.stack([LINES[0], LINES[0, ::-1]]), peak_power=np.ones(2),
                                variance_bins2=np.ones(2), decay_rate=np.ones(2)),
    }  # fmt: skip


def sweep_borders(*, rng):
    """Every border case by the public functions; a case that must be refused is wrong if it is not."""
    methods = ("exact", "planned", "render")
    rows = [row(SETTING, name, m, _verdict(case, m, rng)) for name, case in border_cases().items() for m in methods]
    for name, case in refused_cases().items():
        # The exact form is given neither tolerance nor noise.
        given = methods[1:] if name in ("tolerance zero", "noise negative") else methods
        rows += [row(SETTING, name, method, _refusal(case, method, rng)) for method in given]
    return rows


def _verdict(case, method, rng):
    if method != "render":
        return case.verdict(method)
    limit_db = case.tolerance_db + RENDER_SPECKLE_DB
    try:
        power = _rendered(case, rng)
    except ValueError:
        return np.nan, limit_db, "refused"
    exact = case.computed("exact") + case.noise_power
    error_db = largest_error_db(power, exact, 0.0)
    return error_db, limit_db, outcome(error_db, limit_db)


def _refusal(case, method, rng):
    """Verdict on a case that has no right answer."""
    try:
        _rendered(case, rng) if method == "render" else case.computed(method)
    except ValueError:
        return np.nan, case.tolerance_db, "refused"
    return np.inf, case.tolerance_db, "wrong"


def _rendered(case, rng):
    """Power with noise after so many looks that it is all but the mean."""
    parameters = {name: getattr(case, name) for name in ("peak_power", "variance_bins2", "decay_rate", "noise_power")}
    return render(case.layer_bins, parameters | {"n_looks": RENDER_LOOKS}, case.n_range_bins, rng=rng,
                  tolerance_db=case.tolerance_db, normalise="none", align="gaussian")  # fmt: skip
