"""Where ways of computing PHY fail: scenes pushed until they do, compared with quadrature.

The outcome of a row is ``within`` its limit, ``refused`` by a ValueError, or ``wrong``.
"""

import numpy as np
import pandas as pd
from scipy.special import erfc, gammaincinv
from scipy.stats import gamma

from evaluation.lib.literal_phy import convolved_power, largest_error_db, summed_power
from snowsim.phy.power import checked_waveforms, echoes_of_parameters, exact_power, power_of
from snowsim.phy.speckle import METHODS, draw_speckle

N_RANGE_BINS = 256
LINES = np.array([0.0, 0.26, 0.53, 0.77])  # sub-bin positions
SPACING_BINS = 60
RELATIVE_NOISE = 1e-3  # to the peak of the weakest layer
LEAST_NOISE = 1e-8  # to that of the strongest
EXACT_LIMIT_DB = 1e-11  # rounding: the waveform to 1e-12, amplitudes and sums to a few more
TABLE_LIMIT_DB = 0.05
LITERAL_LIMIT_DB = 0.5  # the speckle of 100 looks is 0.43 dB
RATES = 10.0 ** np.arange(-6, 4.1, 0.5)  # outlast the window; are shorter than a bin
VARIANCES = 10.0 ** np.arange(-6, 8.1, 0.5)  # far narrower than a bin; far wider than the window
WEAKER_DB = np.arange(-300, 1, 20)
# Speckle is drawn on this many pixels for every number of looks, and compared at these levels of
# its law.
LOOKS = (0.5, 1, 1.5, 2, 4, 16, 100, 1e3, 1e4, 1e5, 1e6, 1e7, 1e9)
SHAPE = (512, 512)
LEVELS = np.array([0.01, 0.1, 0.5, 0.9, 0.99])
MOST_LOOKS_SUMMED = 20  # more take seconds
LAW_LIMIT_DB = 0.05
# Settings of the quadrature.
REACH_DEVIATIONS = 9.5  # beyond, a Gaussian is below 3e-20 of its peak
REACH_DECAYS = 45  # beyond, an exponential is
NODES, WEIGHTS = np.polynomial.legendre.leggauss(128)


def draw_atlas(*, rng):
    """Rows of all sweeps as a table; errors keep three digits, the rest differs by machine."""
    rows = []
    for rate in RATES:
        rows += compared("decay rate [per bin]", rate, plain_layers(decay_rate=rate))
    for variance in VARIANCES:
        rows += compared("variance [bins²]", variance, plain_layers(variance_bins2=variance))
    for weaker_db in WEAKER_DB:
        waveforms = plain_layers([1.0, 10 ** (weaker_db / 10)])
        rows += compared("power of the weaker layer [dB]", weaker_db, waveforms)
    for n_looks in LOOKS:
        rows += compared_speckle(n_looks, rng)
    atlas = pd.DataFrame(rows)
    atlas["error_db"] = [float(f"{error_db:.3g}") for error_db in atlas["error_db"]]
    return atlas


def plain_layers(peak_power=(1.0,), variance_bins2=12.0, decay_rate=0.07):
    """`Waveforms` of layers that differ in power alone.

    As printed, so that the outcome does not rest on where a peak was found.
    """
    n_layers = len(peak_power)
    first_bins = 100 + SPACING_BINS * np.arange(n_layers)[:, None]
    echoes = echoes_of_parameters(
        first_bins + LINES,
        peak_power,
        np.full(n_layers, variance_bins2),
        np.full(n_layers, decay_rate),
    )
    return checked_waveforms(echoes, N_RANGE_BINS, as_printed=True)


@np.errstate(all="ignore")
def compared(sweep, value, waveforms):
    """Rows of one scene: mean power by every way.

    Noise is 30 dB below its weakest peak, and at most 80 below its strongest. The exact form is
    held to its own error, others to that of power plus noise.
    """
    peak_power = waveforms.amplitude.max(axis=1) * waveforms.unit_peak
    # As much below the weakest peak, but no more below the strongest than tables are meant for.
    noise_power = max(RELATIVE_NOISE * peak_power.min(), LEAST_NOISE * peak_power.max())
    expected = summed_power(waveforms, waveform_by_quadrature)
    ways = {
        "exact": (exact_power(waveforms), 0.0, EXACT_LIMIT_DB),
        "table": (power_of(waveforms), noise_power, TABLE_LIMIT_DB),
        "naive closed form": (
            summed_power(waveforms, waveform_naive),
            noise_power,
            LITERAL_LIMIT_DB,
        ),
        "convolution": (convolved_power(waveforms), noise_power, LITERAL_LIMIT_DB),
    }
    rows = []
    for method, (power, noise, limit_db) in ways.items():
        error_db = largest_error_db(power, expected, noise)
        rows.append(_row(sweep, value, method, error_db, limit_db))
    return rows


def compared_speckle(n_looks, rng):
    """Rows of one number of looks: quantiles of speckle by every method, against Gamma(M) / M.

    They are within up to `LAW_LIMIT_DB` and five standard errors of the draws.
    """
    exact = gammaincinv(n_looks, LEVELS) / n_looks
    density = gamma.pdf(exact, n_looks, scale=1 / n_looks)
    standard_error = np.sqrt(LEVELS * (1 - LEVELS) / np.prod(SHAPE)) / (density * exact)
    limit_db = LAW_LIMIT_DB + 10 * np.log10(1 + 5 * standard_error)
    ones = np.ones(SHAPE, dtype=np.float32)
    rows = []
    for method in METHODS:
        if method == "looks" and n_looks > MOST_LOOKS_SUMMED:
            continue
        at = ("looks", n_looks, method)
        try:
            drawn = draw_speckle(ones, n_looks, method=method, rng=rng)
        except ValueError:
            rows.append(_row(*at, np.nan, limit_db.max()))
            continue
        error_db = np.abs(10 * np.log10(np.quantile(drawn, LEVELS) / exact))
        worst = np.argmax(error_db / limit_db)
        rows.append(_row(*at, error_db[worst], limit_db[worst]))
    return rows


def _row(sweep, value, method, error_db, limit_db):
    """A row of the atlas; NaN is the error of what was refused."""
    outcome = "within" if error_db <= limit_db else "wrong"
    if np.isnan(error_db):
        outcome = "refused"
    return {
        "sweep": sweep,
        "value": value,
        "method": method,
        "error_db": error_db,
        "limit_db": limit_db,
        "outcome": outcome,
    }


def waveform_naive(x_bins, variance_bins2, decay_rate):
    """The closed form as it is usually written.

    It overflows for wide or fast-decaying waveforms, NaN in its head.
    """
    z = (decay_rate * variance_bins2 - x_bins) / np.sqrt(2 * variance_bins2)
    exponent = decay_rate**2 * variance_bins2 / 2 - decay_rate * x_bins
    return np.sqrt(np.pi * variance_bins2 / 2) * np.exp(exponent) * erfc(z)


@np.errstate(under="ignore", over="ignore")
def waveform_by_quadrature(x_bins, variance_bins2, decay_rate):
    """Waveform of one layer, ``int_0^inf exp(-(x - t)^2 / 2d - a t) dt``, of the shape of `x_bins`.

    Gauss-Legendre over where the integrand exceeds 1e-19 of its largest value: all terms are
    positive, none cancel. Over u = t - t0, t0 >= 0 where the integrand is largest: there ``x - t0 =
    min(a d, x)``.
    """
    x = np.asarray(x_bins, dtype=float)[..., None]
    reach = REACH_DEVIATIONS * np.sqrt(variance_bins2)
    largest_at = np.maximum(x - decay_rate * variance_bins2, 0)
    away = np.minimum(decay_rate * variance_bins2, x)
    largest = -(away**2) / (2 * variance_bins2) - decay_rate * largest_at
    slope = np.maximum(decay_rate - x / variance_bins2, 0)  # where t0 = 0: the integrand's fall
    start = -np.minimum(largest_at, reach)
    stop = np.minimum(reach, REACH_DECAYS / np.maximum(slope, 1e-300))
    half = (stop - start) / 2
    u = start + half * (1 + NODES)
    exponent = largest - slope * u - u**2 / (2 * variance_bins2)
    return (half * WEIGHTS * np.exp(exponent)).sum(axis=-1)
