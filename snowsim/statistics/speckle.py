"""Speckle (its law, its correlation down range, its spectra along track) and fading of layers."""

import numpy as np
from scipy.optimize import least_squares
from scipy.special import betaincinv

from snowsim.constants import BLOCK_LINES
from snowsim.limits import check_count
from snowsim.seeding import rounded
from snowsim.statistics.summaries import GROUP_LINES, in_blocks, in_stretches, known_mean, numbered

DB = 10 / np.log(10)  # decibels in one neper of power
# Options of least squares with which processors agree to 1e-11: complex steps have no error of
# differences, and dogbox reaches a bound exactly.
TO_THE_LAST_DIGITS = {
    "method": "dogbox",
    "jac": "cs",
    "ftol": 1e-15,
    "xtol": 1e-15,
    "gtol": 1e-15,
}
MOST_LOOKS = 1e6  # looks of power without speckle
SPECKLE_LAGS = 9  # range bins: a range response is 2 to 4 of them long
MINIMUM_PAIRS = 10_000  # pairs of bins in the air at every lag: a correlation errs by 0.01
TAIL = np.array([0.001, 0.002, 0.005])
QUANTILES = np.concatenate([TAIL, np.linspace(0.01, 0.99, 99), [0.995, 0.998, 0.999]])
SPECTRUM_BITS = 10  # of Doppler spectra: phases drawn in float32 leave 2e-6
SPECTRUM_LAYERS = 15  # the mean spectrum is that of layers 1 to 15, as in Fig. 8 of the paper
# Least share of the power on a pick that is the layer's own; else noise and tails hide its fading.
OWN_SHARE = 0.5
# Lags of the autocovariance of power in dB; its value at lag 0 follows from the others.
FADING_LAGS = np.array([0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96])
FEWEST_BLOCKS = 4


def decibels(power):
    """Power in dB, NaN where it is not positive."""
    return DB * np.log(np.where(power > 0, power, np.nan))


def looks(summary):
    """Variables of speckle, and the number of looks that fits tracked power.

    `tracked_power_quantile` and `gamma_quantile (probability)`, see `compare_with_gamma`;
    `speckle_correlation (speckle_lag)`, see `range_correlation`; and along-track spectra of
    detected power under the picks, for files without phase, `detected_power_spectrum_layer_1` and
    `_layer_mean (wavenumber)`, on average over layers 1 to `SPECTRUM_LAYERS`: density of power over
    its block mean, about the mean, over its own mean: 1 everywhere where lines are independent.
    Blocks with a gap are left out for that layer, and a spectrum without a block.
    """
    of_groups = in_stretches(summary, "tracked_power", GROUP_LINES, summary["n_groups"].values)
    n_looks, tracked_quantile, gamma_quantile = compare_with_gamma(of_groups.swapaxes(1, 2))
    correlation = range_correlation(summary["air_products"].values, summary["air_pairs"].values)
    variables = {
        "tracked_power_quantile": ("probability", tracked_quantile),
        "gamma_quantile": ("probability", gamma_quantile),
        "speckle_correlation": ("speckle_lag", correlation),
    }
    power = in_blocks(summary, "tracked_power")[:, :, 1 : SPECTRUM_LAYERS + 1]
    mean = power.mean(axis=1, keepdims=True)
    relative = power / np.where(mean > 0, mean, np.nan)
    density = known_mean(np.abs(np.fft.rfft(relative, axis=1)[:, 1:]) ** 2, axis=0)
    level = density.mean(axis=0)
    seen = level > 0
    spectra = np.pad(density[:, seen] / level[seen], [(1, 0), (0, 0)])
    if seen[:1].any():
        variables["detected_power_spectrum_layer_1"] = "wavenumber", spectra[:, 0]
    if seen.any():
        variables["detected_power_spectrum_layer_mean"] = "wavenumber", spectra.mean(axis=1)
    return variables, n_looks


def compare_with_gamma(tracked):
    """Number of looks that fits tracked power, its quantiles, and those of Gamma(M).

    Quantiles are at `QUANTILES`.

    `tracked (group, layer, line of the group)` is linear, NaN in gaps; only layers picked in every
    line of a group count, and fewer than two are refused. Yari et al. (2021) call tracked peak
    power chi-square; the average of M looks is Gamma(M). Each value is divided by the mean of its
    20 lines, which removes changes along track: if all are Gamma(M) of one mean, the quotient is 20
    times a Beta(M, 19 M) of variance ``19 / (20 M + 1)``, and looks (at most `MOST_LOOKS`, for
    power without speckle) and quantiles follow without bias.
    """
    whole = tracked[tracked.mean(axis=2) > 0]
    check_count(f"groups of {GROUP_LINES} lines without gaps in a layer", len(whole), 2)
    ratio = whole / whole.mean(axis=1, keepdims=True)
    others = GROUP_LINES - 1
    # Without speckle the variance is rounding alone; the law is then a single value.
    variance = max(ratio.var(axis=1).mean(), others / (GROUP_LINES * MOST_LOOKS + 1))
    n_looks = max(others / variance - 1, 1e-3) / GROUP_LINES
    law = GROUP_LINES * betaincinv(n_looks, others * n_looks, QUANTILES)
    return n_looks, np.quantile(ratio, QUANTILES), law


def range_correlation(products, pairs):
    """Autocorrelation of speckle down range (speckle_lag,), from power in the air.

    From sums of products and numbers of pairs (group, air_lag). Noise and echoes pass the same
    range response, so speckle has the correlation of noise. Subtracting means leaves an offset that
    is the same at every lag, read off lags from `SPECKLE_LAGS` on. With fewer than `MINIMUM_PAIRS`
    pairs at a lag, as in few images, or without speckle, bins are taken as independent: zero from
    lag 1 on.
    """
    n_pairs = pairs.sum(axis=0)
    covariance = products.sum(axis=0) / np.maximum(n_pairs, 1)
    common = covariance[SPECKLE_LAGS:].mean()
    variance = covariance[0] - common
    if n_pairs.min() < MINIMUM_PAIRS or variance < 1 / MOST_LOOKS:
        return np.eye(1, SPECKLE_LAGS)[0]
    return (covariance[:SPECKLE_LAGS] - common) / variance


def doppler_spectra(amplitude, layer_bins, line_spacing_m):
    """Along-track wavenumber spectrum of complex echoes under the picks (Fig. 8 of the paper).

    `amplitude (range_bin, range_line)` is elevation-compensated and undetected, `layer_bins (layer,
    range_line)` the picks, layer 1 without a gap; others with a gap are left out. Returns the
    two-sided wavenumber [cycles per m], increasing, and power spectral density over its mean of
    layer 1 and on average over layers 1 to `SPECTRUM_LAYERS`.
    """
    layer_bins = np.asarray(layer_bins, dtype=float)[1 : SPECTRUM_LAYERS + 1]
    within = (layer_bins > -0.5) & (layer_bins < len(amplitude) - 0.5)
    rows = np.rint(layer_bins[within.all(axis=1)]).astype(int)
    n_lines = rows.shape[1]
    density = np.abs(np.fft.fftshift(np.fft.fft(amplitude[rows, np.arange(n_lines)]), axes=1)) ** 2
    spectra = density / density.mean(axis=1, keepdims=True)
    wavenumber = np.fft.fftshift(np.fft.fftfreq(n_lines, line_spacing_m))
    first, mean = rounded([spectra[0], spectra.mean(axis=0)], SPECTRUM_BITS)
    return wavenumber, first, mean


def fading_products(summary, powers):
    """Sums of products of power in dB along track, and numbers of pairs, both by lag.

    One pair (sums, numbers) is for the surface, one for buried layers. Products are of tracked
    power in whole blocks, about its mean. `powers` (group, layer) are those above noise and
    neighbours. Noise and tails do not fade with a layer: a block in which a layer has less than
    `OWN_SHARE` of the power on its picks is left out; in the others, products at lags of one and
    more are divided by the square of that share.
    """
    tracked = in_blocks(summary, "tracked_power").swapaxes(1, 2)
    known = tracked > 0
    own = known_mean(powers[_groups_of_blocks(summary)], axis=1)
    share = own / known_mean(np.where(known, tracked, np.nan), axis=2)
    clear = (share >= OWN_SHARE) & (2 * known.sum(axis=2) >= BLOCK_LINES)
    power_db = decibels(tracked[clear])
    deviation = np.nan_to_num(power_db - known_mean(power_db, axis=1)[:, None])
    products = _by_lag(deviation)
    products[:, 1:] /= np.minimum(share[clear, None], 1) ** 2
    pairs = _by_lag(known[clear])
    buried = np.nonzero(clear)[1] > 0
    return [(products[kind].sum(axis=0), pairs[kind].sum(axis=0)) for kind in (~buried, buried)]


def _groups_of_blocks(summary):
    """Numbers of the groups of every whole block of all frames, (block, group of the block).

    A frame without a surface has no group; its blocks get groups of other frames.
    """
    n_blocks = summary["n_lines"].values // BLOCK_LINES
    n_groups = summary["n_groups"].values
    start = BLOCK_LINES * numbered(n_blocks)
    first = np.repeat(n_groups.cumsum() - n_groups, n_blocks) + start // GROUP_LINES
    group = first[:, None] + np.arange(BLOCK_LINES // GROUP_LINES)
    return np.minimum(group, n_groups.sum() - 1)


def _by_lag(series):
    """Sums of products of values that lie `FADING_LAGS` apart, (series, lag)."""
    spectrum = np.fft.rfft(series, 2 * BLOCK_LINES)
    return np.fft.irfft(np.abs(spectrum) ** 2)[:, FADING_LAGS]


def fading(total, n, speckle):
    """Standard deviation [dB], 1/e length [lines] and exponent of fading, (3,), or NaN.

    One kind of interface, from sums of products, and of pairs, by lag (lag,). ``C(h) = s^2
    exp(-(h / l)^p)`` at lags of one line and more, less what subtracting a block's mean removes: at
    lag h twice the mean of ``c_i = sum_j C(i - j) / n`` over the pairs' lines i, less its mean over
    all n lines of a block. The excess at lag 0 is `speckle` [dB^2].
    """
    if n.min() < BLOCK_LINES * FEWEST_BLOCKS or total[0] <= 0:
        return np.full(3, np.nan)
    covariance = total / n

    def misfit(parameters):
        variance, length = np.exp(parameters[:2])
        shape = np.exp(-((np.arange(1, BLOCK_LINES) / length) ** parameters[2]))
        kernel = variance * np.append(1.0, shape)
        above = np.cumsum(kernel)
        with_mean = (above + above[::-1] - kernel[0]) / BLOCK_LINES
        below = np.cumsum(with_mean[::-1])[::-1]
        removed = 2 * below[FADING_LAGS] / (BLOCK_LINES - FADING_LAGS) - with_mean.mean()
        expected = kernel[FADING_LAGS] - removed - speckle / BLOCK_LINES
        return (expected - covariance)[1:] * np.sqrt(n[1:] / n[1])

    lower = [np.log(1e-4), 0.0, 0.3]
    upper = [np.log(1e3), np.log(4.0 * BLOCK_LINES), 2.0]
    guess = np.clip([np.log(max(covariance[1], 1e-3)), np.log(30.0), 1.5], lower, upper)
    fit = least_squares(misfit, guess, bounds=(lower, upper), **TO_THE_LAST_DIGITS)
    return np.append(np.exp(fit.x[:2] / [2, 1]), fit.x[2])
