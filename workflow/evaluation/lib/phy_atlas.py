"""The atlas of PHY: scenes pushed to where ways of computing them fail, public functions included.

The outcome of a row is ``within`` its limit, ``refused`` by a ValueError, or ``wrong``.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pandas as pd
from scipy.special import gammaincinv
from scipy.stats import gamma

from evaluation.lib.phy_cases import CONVENTIONS, Case, Found, found_by, held_to, noisy, row
from evaluation.lib.phy_errors import largest_error_db
from snowsim.phy.render import render
from snowsim.phy.speckle import draw_speckle

# What the package offers, of which nothing may be wrong; all other methods are there to fail.
PUBLIC = ("exact", "planned", "render", "looks", "gamma", "cube", "quantile")
SHORTCUTS = ("naive", "sampled", "wrapped", "cut", "nearest", "recursive32")
LINES = np.array([[0.0, 0.26, 0.53, 0.77]])  # sub-bin positions
# One layer, peaking at 6.7 with noise of 1e-3 under it.
PLAIN = Case(100 + LINES, np.ones(1), np.full(1, 12.0), np.full(1, 0.07))
# Speckle is drawn on this many pixels for every number of looks, and compared at these levels of
# its law.
LOOKS = (0.5, 1, 1.5, 2, 4, 9, 10, 16, 20, 100, 1e3, 1e4, 1e5, 1e6, 1e7, 1e9)
SHAPE = (512, 512)
LEVELS = np.array([0.01, 0.1, 0.5, 0.9, 0.99])
MOST_LOOKS_SUMMED = 20  # more take seconds
LAW_LIMIT_DB = 0.05
# Speckle of 1e6 looks is 4.3e-3 dB: six deviations are allowed to it.
RENDER_LOOKS = 1e6
RENDER_SPECKLE_DB = 0.03


@dataclass(frozen=True)
class Sweep:
    """Values of one setting, the scene of a value, and the methods beside `exact` and `planned`."""

    setting: str
    values: Iterable
    case_of: Callable
    methods: tuple

    def rows(self):
        """Rows of the atlas: the case of every value by every method."""
        rows = []
        for value in self.values:
            case = self.case_of(value)
            for method in ("exact", "planned", *self.methods):
                rows.append(row(self.setting, value, method, case.found(method)))
        return rows


def _pair(spacing_bins, peak_power=(1.0, 1.0)):
    """Two plain layers."""
    return replace(
        PLAIN,
        layer_bins=np.concatenate([PLAIN.layer_bins, PLAIN.layer_bins + spacing_bins]),
        peak_power=np.array(peak_power),
        variance_bins2=np.repeat(PLAIN.variance_bins2, 2),
        decay_rate=np.repeat(PLAIN.decay_rate, 2),
    )


def _plain(noise_power=PLAIN.noise_power, **of_layer):
    """The plain layer with other numbers."""
    changes = {name: np.array([value]) for name, value in of_layer.items()}
    return replace(PLAIN, noise_power=noise_power, **changes)


def sweeps():
    """Every sweep over numbers."""
    # From exponentials that outlast the window to ones shorter than a bin.
    rates = 10.0 ** np.arange(-6, 4.1, 0.5)
    yield Sweep("decay rate [per bin]", rates, lambda a: noisy(_plain(decay_rate=a)), SHORTCUTS)
    # From far narrower than a bin to far wider than the window.
    widths = 10.0 ** np.arange(-6, 8.1, 0.5)
    methods = (*SHORTCUTS, "recursive64")
    yield Sweep("variance [bins²]", widths, lambda d: noisy(_plain(variance_bins2=d)), methods)
    # Across the borders of the window of 256 bins, on them, and far outside.
    above = -(10.0 ** np.arange(4, 0.9, -0.5))
    inside = [-1, 0, 10, 50, 128, 200, 240, 250, 254, 255, 256, 260, 300]
    places = [*above, *inside, 1e3, 1e4]
    yield Sweep(
        "position [bins]", places, lambda x: replace(PLAIN, layer_bins=x + LINES), SHORTCUTS
    )
    # Touching, and crossing, which is refused.
    distances = [-10, -1, -1e-3, 0, *10.0 ** np.arange(-15, 2.1)]
    methods = ("naive", "sampled", "nearest", "recursive32")
    yield Sweep("spacing of two layers [bins]", distances, _pair, methods)
    # The noise is 30 dB below the weaker layer.
    ratios = 10.0 ** np.array([-300, -250, -200, -150, -100, -50, *range(-30, 1, 2)])
    methods += ("table32",)
    yield Sweep("power of the weaker layer", ratios, lambda m: noisy(_pair(60, (1, m))), methods)
    # From loose to below the resolution of float32, then of float64.
    tolerances_db = [10, 3, 1, *10.0 ** np.arange(-0.5, -15.1, -0.5)]
    methods = ("table32",)
    yield Sweep("tolerance [dB]", tolerances_db, lambda x: replace(PLAIN, tolerance_db=x), methods)
    # One column of a layer whose tail hardly decays, from one pixel to a million.
    heights = [1, 2, 3, *(10**power for power in range(1, 7))]
    methods = ("wrapped", "cut", "recursive32", "recursive64")
    yield Sweep("height [bins]", heights, _column, methods)


def _column(height):
    layer_bins = np.array([[0.3 * height]])
    return replace(_plain(decay_rate=1e-6), layer_bins=layer_bins, n_range_bins=height)


def sweep_looks(*, rng):
    """Number of looks: from one, the most skewed law, to where float32 tells no values apart.

    `cube_open` is the cube without the floor of 10 looks that `draw_speckle` holds it to.
    """
    rows = []
    for n_looks in LOOKS:
        for method in ("looks", "gamma", "cube", "quantile", "cube_open"):
            if method != "looks" or n_looks <= MOST_LOOKS_SUMMED:
                rows.append(row("looks M", n_looks, method, _looks_found(method, n_looks, rng)))
    return rows


def _looks_found(method, n_looks, rng):
    """Quantiles are within up to `LAW_LIMIT_DB` and five standard errors of the draws."""
    exact = gammaincinv(n_looks, LEVELS) / n_looks
    density = gamma.pdf(exact, n_looks, scale=1 / n_looks)
    standard_error = np.sqrt(LEVELS * (1 - LEVELS) / np.prod(SHAPE)) / (density * exact)
    limit_db = LAW_LIMIT_DB + 10 * np.log10(1 + 5 * standard_error)
    try:
        drawn = _speckle(method, n_looks, rng)
    except ValueError:
        return Found(np.nan, limit_db.max(), "refused")
    quantiles = np.quantile(drawn, LEVELS)
    if np.any(quantiles <= 0):
        return Found(np.inf, limit_db.max(), "wrong")
    error_db = np.abs(10 * np.log10(quantiles / exact))
    worst = np.argmax(error_db / limit_db)
    return held_to(error_db[worst], limit_db[worst])


def _speckle(method, n_looks, rng):
    """Speckle of mean 1; ValueError where the method does not draw so many looks."""
    if method != "cube_open":
        return draw_speckle(np.ones(SHAPE, dtype=np.float32), n_looks, method=method, rng=rng)
    scatter = rng.standard_normal(SHAPE) / (3 * np.sqrt(n_looks))
    return (1 - 1 / (9 * n_looks) + scatter) ** 3


def border_cases():
    """Scenes at the limits of valid input, by name."""
    nothing = np.empty(0)
    none = Case(np.empty((0, 4)), nothing, nothing, nothing)
    return {
        "no layers": none,
        "all absent": replace(PLAIN, layer_bins=np.nan * LINES),
        "partly absent": replace(PLAIN, layer_bins=np.where(LINES > 0.5, np.nan, 100 + LINES)),
        "no range lines": replace(PLAIN, layer_bins=np.empty((1, 0))),
        "one pixel": replace(PLAIN, layer_bins=np.zeros((1, 1)), n_range_bins=1),
        "one row": replace(PLAIN, layer_bins=0 * LINES, n_range_bins=1),
        "on top border": replace(PLAIN, layer_bins=0 * LINES),
        "half above top": replace(PLAIN, layer_bins=0 * LINES - 0.5),
        "on bottom border": replace(PLAIN, layer_bins=0 * LINES + 255),
        "half below bottom": replace(PLAIN, layer_bins=0 * LINES + 255.5),
        "no noise": _plain(0.0),
        "noise over peak": _plain(1e3),
        "no power": _plain(0.0, peak_power=0.0),
        "power of 1e-280": _plain(1e-283, peak_power=1e-280),
        "power of 1e300": _plain(1e297, peak_power=1e300),
    }


def refused_cases():
    """Scenes that must be refused, by name."""
    return {
        "power NaN": _plain(peak_power=np.nan),
        "power infinite": _plain(peak_power=np.inf),
        "power negative": _plain(peak_power=-1.0),
        "power overflows": _plain(peak_power=1.7e308),
        "variance zero": _plain(variance_bins2=0.0),
        "decay negative": _plain(decay_rate=-1.0),
        "position infinite": replace(PLAIN, layer_bins=np.where(LINES > 0.5, np.inf, LINES)),
        "no rows": replace(PLAIN, n_range_bins=0),
        "half a row": replace(PLAIN, n_range_bins=2.5),
        "tolerance zero": replace(PLAIN, tolerance_db=0.0),
        "noise negative": _plain(-1e-3),
        "layers cross": replace(_pair(0), layer_bins=np.stack([LINES[0], LINES[0, ::-1]])),
    }


def sweep_borders(*, rng):
    """Border cases by the public functions; one that must be refused is wrong if it is not."""
    methods = ("exact", "planned", "render")
    rows = []
    for name, case in border_cases().items():
        for method in methods:
            rows.append(row("borders", name, method, _border_found(case, method, rng)))
    for name, case in refused_cases().items():
        # The exact form is given neither tolerance nor noise.
        given = methods[1:] if name in ("tolerance zero", "noise negative") else methods
        for method in given:
            work = partial(_computed, case, method, rng)
            found = found_by(work, lambda power: np.inf, case.tolerance_db)
            rows.append(row("borders", name, method, found))
    return rows


def _border_found(case, method, rng):
    if method != "render":
        return case.found(method)

    def error_db(power):
        return largest_error_db(power, case.computed("exact") + case.noise_power, 0.0)

    limit_db = case.tolerance_db + RENDER_SPECKLE_DB
    return found_by(partial(_computed, case, method, rng), error_db, limit_db)


def _computed(case, method, rng):
    """Power by a public function; of a render with noise, after so many looks all but the mean."""
    if method != "render":
        return case.computed(method)
    parameters = {
        "peak_power": case.peak_power,
        "variance_bins2": case.variance_bins2,
        "decay_rate": case.decay_rate,
        "noise_power": case.noise_power,
        "n_looks": RENDER_LOOKS,
    }
    return render(
        case.layer_bins,
        parameters,
        case.n_range_bins,
        rng=rng,
        tolerance_db=case.tolerance_db,
        **CONVENTIONS,
    )


def draw_atlas(*, rng):
    """Rows of all sweeps as a table."""
    rows = []
    for sweep in sweeps():
        rows += sweep.rows()
    rows += sweep_looks(rng=rng)
    rows += sweep_borders(rng=rng)
    return pd.DataFrame(rows)


def summarise_atlas(atlas):
    """Where each method of each sweep is within its limit.

    First and last value of the longest run of numbers without a wrong one; refusals at its ends are
    left out; empty where no value is within.
    """
    rows = []
    for (setting, method), sweep in atlas.groupby(["setting", "method"], sort=False):
        row = {"setting": setting, "method": method, "first_safe": None, "last_safe": None}
        if pd.api.types.is_number(sweep["value"].iloc[0]):
            safe = _longest_run(sweep)
            if len(safe):
                row["first_safe"] = safe.iloc[0]
                row["last_safe"] = safe.iloc[-1]
        for name in ("within", "refused", "wrong"):
            row[f"n_{name}"] = (sweep["outcome"] == name).sum()
        rows.append(row)
    return pd.DataFrame(rows)


def _longest_run(sweep):
    """Values within, of the longest stretch of a sweep that has no wrong one."""
    sweep = sweep.sort_values("value", kind="stable")
    run = (sweep["outcome"] == "wrong").cumsum()
    within = sweep.loc[sweep["outcome"] == "within", "value"]
    runs = [values for _, values in within.groupby(run)]
    return max(runs, key=len, default=within)
