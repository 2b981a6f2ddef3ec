"""The atlas of PHY: scenes pushed to where ways of computing them fail, the public functions among them.

The outcome of a row is ``within`` its limit, ``refused`` by a ValueError, or ``wrong``.
"""

from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
from scipy.special import gammaincinv
from scipy.stats import gamma

from lib.diagnostics.phy_cases import Case, compared, noisy, outcome, outcome_of, row
from lib.diagnostics.phy_errors import largest_error_db
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
SHAPE, LEVELS = (512, 512), np.array([0.01, 0.1, 0.5, 0.9, 0.99])
MOST_LOOKS_SUMMED = 20  # more take seconds
LAW_LIMIT_DB = 0.05
# Speckle of 1e6 looks is 4.3e-3 dB: six deviations are allowed to it.
RENDER_LOOKS, RENDER_SPECKLE_DB = 1e6, 0.03


def _pair(spacing_bins, **changes):
    """Two plain layers."""
    both = {
        name: np.repeat(getattr(PLAIN, name), 2)
        for name in ("peak_power", "variance_bins2", "decay_rate")
    }
    layer_bins = np.concatenate([PLAIN.layer_bins, PLAIN.layer_bins + spacing_bins])
    return replace(PLAIN, layer_bins=layer_bins, **(both | changes))


def sweeps():
    """Setting, values, scene of one, and methods beside `exact` and `planned`, of every sweep over numbers."""

    def plain_with(name):
        return lambda x: noisy(replace(PLAIN, **{name: np.array([x])}))

    # From exponentials that outlast the window to ones shorter than a bin.
    yield (
        "decay rate [per bin]",
        10.0 ** np.arange(-6, 4.1, 0.5),
        plain_with("decay_rate"),
        SHORTCUTS,
    )
    # From far narrower than a bin to far wider than the window.
    widths = 10.0 ** np.arange(-6, 8.1, 0.5)
    yield "variance [bins²]", widths, plain_with("variance_bins2"), (*SHORTCUTS, "recursive64")
    # Across the borders of the window of 256 bins, on them, and far outside.
    inside = [-1, 0, 10, 50, 128, 200, 240, 250, 254, 255, 256, 260, 300]
    places = [*-(10.0 ** np.arange(4, 0.9, -0.5)), *inside, 1e3, 1e4]
    yield "position [bins]", places, lambda x: replace(PLAIN, layer_bins=x + LINES), SHORTCUTS
    # Touching, and crossing, which is refused.
    distances = [-10, -1, -1e-3, 0, *10.0 ** np.arange(-15, 2.1)]
    yield (
        "spacing of two layers [bins]",
        distances,
        _pair,
        ("naive", "sampled", "nearest", "recursive32"),
    )
    # The noise is 30 dB below the weaker layer.
    ratios = 10.0 ** np.array([-300, -250, -200, -150, -100, -50, *range(-30, 1, 2)])
    methods = ("naive", "sampled", "nearest", "recursive32", "table32")
    yield (
        "power of the weaker layer",
        ratios,
        lambda x: noisy(_pair(60, peak_power=np.array([1, x]))),
        methods,
    )
    # From loose to below the resolution of float32, then of float64.
    tolerances_db = [10, 3, 1, *10.0 ** np.arange(-0.5, -15.1, -0.5)]
    yield "tolerance [dB]", tolerances_db, lambda x: replace(PLAIN, tolerance_db=x), ("table32",)
    # One column of a layer whose tail hardly decays, from one pixel to a million.
    slow = replace(PLAIN, decay_rate=np.array([1e-6]))
    heights = [1, 2, 3, *(10**power for power in range(1, 7))]
    methods = ("wrapped", "cut", "recursive32", "recursive64")
    yield (
        "height [bins]",
        heights,
        lambda x: replace(slow, layer_bins=np.array([[0.3 * x]]), n_range_bins=x),
        methods,
    )


def sweep_looks(*, rng):
    """Number of looks: from one, where laws are most skewed, to where float32 no longer tells values apart.

    `cube_open` is the cube without the floor of 10 looks that `draw_speckle` holds it to.
    """
    methods = ("looks", "gamma", "cube", "quantile", "cube_open")
    runs = [
        (n, method)
        for n in LOOKS
        for method in methods
        if method != "looks" or n <= MOST_LOOKS_SUMMED
    ]
    return [
        row("looks M", n_looks, method, _looks_outcome(method, n_looks, rng))
        for n_looks, method in runs
    ]


def _looks_outcome(method, n_looks, rng):
    """Quantiles are within when off by at most `LAW_LIMIT_DB` and five standard errors of the draws."""
    exact = gammaincinv(n_looks, LEVELS) / n_looks
    density = gamma.pdf(exact, n_looks, scale=1 / n_looks)
    standard_error = np.sqrt(LEVELS * (1 - LEVELS) / np.prod(SHAPE)) / (density * exact)
    limit_db = LAW_LIMIT_DB + 10 * np.log10(1 + 5 * standard_error)
    try:
        if method == "cube_open":
            drawn = (
                1 - 1 / (9 * n_looks) + rng.standard_normal(SHAPE) / (3 * np.sqrt(n_looks))
            ) ** 3
        else:
            drawn = draw_speckle(np.ones(SHAPE, dtype=np.float32), n_looks, method=method, rng=rng)
    except ValueError:
        return np.nan, float(limit_db.max()), "refused"
    quantiles = np.quantile(drawn, LEVELS)
    if np.any(quantiles <= 0):
        return np.inf, float(limit_db.max()), "wrong"
    error_db = np.abs(10 * np.log10(quantiles / exact))
    worst = np.argmax(error_db / limit_db)
    return error_db[worst], float(limit_db[worst]), outcome(error_db[worst], limit_db[worst])


def border_cases():
    """Scenes at the limits of valid input, by name."""
    nothing = np.empty(0)
    none = {
        "layer_bins": np.empty((0, 4)),
        "peak_power": nothing,
        "variance_bins2": nothing,
        "decay_rate": nothing,
    }
    return {
        "no layers": replace(PLAIN, **none),
        "all absent": replace(PLAIN, layer_bins=np.nan * LINES),
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
        "layers cross": replace(_pair(0), layer_bins=np.stack([LINES[0], LINES[0, ::-1]])),
    }


def sweep_borders(*, rng):
    """Every border case by the public functions; a case that must be refused is wrong if it is not."""
    methods = ("exact", "planned", "render")
    rows = [
        row("borders", name, m, _outcome(case, m, rng))
        for name, case in border_cases().items()
        for m in methods
    ]
    for name, case in refused_cases().items():
        # The exact form is given neither tolerance nor noise.
        given = methods[1:] if name in ("tolerance zero", "noise negative") else methods
        rows += [row("borders", name, method, _refusal(case, method, rng)) for method in given]
    return rows


def _outcome(case, method, rng):
    if method != "render":
        return case.outcome(method)

    def error_db(power):
        return largest_error_db(power, case.computed("exact") + case.noise_power, 0.0)

    return outcome_of(
        partial(_rendered, case, rng), error_db, case.tolerance_db + RENDER_SPECKLE_DB
    )


def _refusal(case, method, rng):
    """Outcome of a case that has no right answer."""
    work = partial(_rendered, case, rng) if method == "render" else partial(case.computed, method)
    return outcome_of(work, lambda power: np.inf, case.tolerance_db)


def _rendered(case, rng):
    """Power with noise after so many looks that it is all but the mean."""
    parameters = {
        name: getattr(case, name)
        for name in ("peak_power", "variance_bins2", "decay_rate", "noise_power")
    }
    return render(case.layer_bins, parameters | {"n_looks": RENDER_LOOKS}, case.n_range_bins, rng=rng,
                  tolerance_db=case.tolerance_db, normalise="none", align="gaussian")  # fmt: skip


def draw_atlas(*, rng):
    """Rows of all sweeps as a table."""
    rows = [row for sweep in sweeps() for row in compared(*sweep)]
    rows += [*sweep_looks(rng=rng), *sweep_borders(rng=rng)]
    return pd.DataFrame(rows)


def summarise_atlas(atlas):
    """Where each method of each sweep is within its limit: ends of the longest run of numbers without a wrong one.

    Refusals at its ends are left out; empty where no value is within.
    """
    rows = []
    for (setting, method), sweep in atlas.groupby(["setting", "method"], sort=False):
        counts = {
            f"n_{name}": int((sweep["outcome"] == name).sum())
            for name in ("within", "refused", "wrong")
        }
        safe = pd.DataFrame()
        if pd.api.types.is_number(sweep["value"].iloc[0]):
            sweep = sweep.sort_values("value", kind="stable")
            run = (sweep["outcome"] == "wrong").cumsum()
            runs = [each for _, each in sweep[sweep["outcome"] == "within"].groupby(run)]
            safe = max(runs, key=len, default=safe)
        ends = (
            {}
            if safe.empty
            else {"first_safe": safe["value"].iloc[0], "last_safe": safe["value"].iloc[-1]}
        )
        rows.append(
            {"setting": setting, "method": method, "first_safe": None, "last_safe": None}
            | ends
            | counts
        )
    return pd.DataFrame(rows)
