"""Speckle, against Gamma(M), down range in the air and in along-track spectra.

Fading of layers along track.
"""

import numpy as np
from scipy.optimize import least_squares
from scipy.special import betaincinv

from snowsim.constants import BLOCK_LINES
from snowsim.limits import check_count
from snowsim.rounding import rounded
from snowsim.statistics.moments import TO_THE_LAST_DIGITS, decibels
from snowsim.statistics.summaries import GROUP_LINES

MOST_LOOKS = 1e6  # stands for power without speckle
SPECKLE_LAGS = 9  # range bins: a range response is 2 to 4 of them long
MINIMUM_PAIRS = 10_000  # of bins in the air at every lag: they give a correlation to 0.01
TAIL = np.array([0.001, 0.002, 0.005])
QUANTILES = np.concatenate([TAIL, np.linspace(0.01, 0.99, 99), [0.995, 0.998, 0.999]])
SPECTRUM_BITS = 10  # of Doppler spectra: phases drawn in float32 leave 2e-6
SPECTRUM_LAYERS = 15  # the mean spectrum is that of layers 1 to 15, as in Fig. 8 of the paper
# Fading: autocovariance of power in dB, extrapolated from lags of one line and more to zero.
# Of power on a pick that must be the layer's own, or noise and tails hide its fading.
CLEAR_SHARE = 0.5
FADING_LAGS = np.array([1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96])
ALL_LAGS = np.append(0, FADING_LAGS)
FEWEST_BLOCKS = 4


def tracked_by_group(summary, n_layers):
    """Power under the picks of whole groups, (group, layer, line of the group), NaN in gaps."""
    n_lines, n_groups = summary["n_lines"].values, summary["n_groups"].values
    line = np.arange(n_lines.sum()) - np.repeat(n_lines.cumsum() - n_lines, n_lines)
    in_group = line < np.repeat(n_groups * GROUP_LINES, n_lines)
    tracked = summary["tracked_power"].values[in_group, :n_layers].astype(float)
    return tracked.reshape(-1, GROUP_LINES, n_layers).swapaxes(1, 2)


def looks(summary, n_layers):
    """Variables of speckle, and the looks that fit tracked power.

    `tracked_power_quantile` and `gamma_quantile (probability)`, see `compare_with_gamma`;
    `speckle_correlation (speckle_lag)`, see `range_correlation`; and along-track spectra of
    detected power under the picks, for files without phase, `detected_power_spectrum_layer_1` and
    `_layer_mean (wavenumber)`, on average over layers 1 to `SPECTRUM_LAYERS`: density of power over
    its block mean, about the mean, over its own mean: 1 everywhere where lines are independent.
    Blocks with a gap are left out for that layer, and a spectrum without a block.
    """
    n_looks, tracked_quantile, gamma_quantile = compare_with_gamma(
        tracked_by_group(summary, n_layers)
    )
    correlation = range_correlation(summary["air_products"].values, summary["air_pairs"].values)
    variables = {
        "tracked_power_quantile": ("probability", tracked_quantile),
        "gamma_quantile": ("probability", gamma_quantile),
        "speckle_correlation": ("speckle_lag", correlation),
    }
    tracked = summary["tracked_power"].values.astype(float)
    blocks = np.array([tracked[lines].T for lines, _ in whole_blocks(summary)])
    spectra = {}
    for layer in range(1, min(SPECTRUM_LAYERS + 1, tracked.shape[1]) if blocks.size else 1):
        power = blocks[:, layer]
        power = power[np.isfinite(power).all(axis=1) & (power > 0).any(axis=1)]
        relative = power / power.mean(axis=1, keepdims=True)
        density = np.abs(np.fft.rfft(relative)[:, 1:]) ** 2
        if density.any():
            mean = density.mean(axis=0)
            spectra[layer] = np.append(0, mean / mean.mean())
    if 1 in spectra:
        variables["detected_power_spectrum_layer_1"] = "wavenumber", spectra[1]
    if spectra:
        mean = np.mean(list(spectra.values()), axis=0)
        variables["detected_power_spectrum_layer_mean"] = "wavenumber", mean
    return variables, n_looks


def compare_with_gamma(tracked):
    """Looks that fit tracked power, its quantiles, and those of the law, at `QUANTILES`.

    `tracked (group, layer, line of the group)` is linear, NaN in gaps; only layers picked in every
    line of a group count, and fewer than two are refused. Yari et al. (2021) call tracked peak
    power chi-square; the average of M looks is Gamma(M). Each value is divided by the mean of its
    20 lines, which removes changes along track: if all are Gamma(M) of one mean, the quotient is 20
    times a Beta(M, 19 M) of variance ``19 / (20 M + 1)``, and looks (at most `MOST_LOOKS`, for
    power without speckle) and quantiles follow without bias.
    """
    whole = tracked[np.isfinite(tracked).all(axis=2)].astype(float)
    whole = whole[whole.mean(axis=1) > 0]
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


def whole_blocks(summary):
    """Slices of range lines and of groups of every whole block of all frames, a list of pairs."""
    blocks = []
    first_line = first_group = 0
    frames = zip(summary["n_lines"].values, summary["n_groups"].values, strict=True)
    for n_lines, n_groups in frames:
        for start in range(0, n_lines - BLOCK_LINES + 1, BLOCK_LINES):
            line = first_line + start
            group = first_group + start // GROUP_LINES
            last_group = min(group + BLOCK_LINES // GROUP_LINES, first_group + n_groups)
            blocks.append((slice(line, line + BLOCK_LINES), slice(group, last_group)))
        first_line += n_lines
        first_group += n_groups
    return blocks


def doppler_spectra(amplitude, layer_bins, line_spacing_m):
    """Along-track wavenumber spectrum of complex echoes under the picks (Fig. 8 of the paper).

    `amplitude (range_bin, range_line)` is elevation-compensated and undetected, `layer_bins (layer,
    range_line)` the picks, layer 1 without a gap; others with a gap are left out. Returns the
    two-sided wavenumber [cycles per m], increasing, and power spectral density over its mean of
    layer 1 and on average over layers 1 to `SPECTRUM_LAYERS`.
    """
    layer_bins = np.asarray(layer_bins, dtype=float)
    n_lines = layer_bins.shape[1]
    within = (layer_bins > -0.5) & (layer_bins < len(amplitude) - 0.5)
    inside = within.all(axis=1)
    lines = np.arange(n_lines)
    spectra = []
    for rows in layer_bins[1 : SPECTRUM_LAYERS + 1][inside[1 : SPECTRUM_LAYERS + 1]]:
        echo = amplitude[np.rint(rows).astype(int), lines]
        density = np.abs(np.fft.fftshift(np.fft.fft(echo))) ** 2
        spectra.append(density / density.mean())
    wavenumber = np.fft.fftshift(np.fft.fftfreq(n_lines, line_spacing_m))
    mean = np.mean(spectra, axis=0)
    return wavenumber, rounded(spectra[0], SPECTRUM_BITS), rounded(mean, SPECTRUM_BITS)


def fading_products(summary, powers):
    """Products of dB power along track by lag, (surface or buried, lag, 2).

    Sums and numbers. From tracked power in whole blocks, about its mean, and powers (group, layer)
    above noise and neighbours. Noise and tails do not
    fade with a layer: blocks in which it has less than `CLEAR_SHARE` of the power on its picks are
    left out; in the others, products at lags of one and more are divided by the square of that
    share.
    """
    products = np.zeros((2, ALL_LAGS.size, 2))
    all_tracked = summary["tracked_power"].values
    for lines, groups in whole_blocks(summary):
        own = powers[groups]
        for layer in np.flatnonzero(np.isfinite(own).any(axis=0)):
            tracked = all_tracked[lines, layer].astype(float)
            known = tracked > 0
            if 2 * known.sum() < BLOCK_LINES:
                continue
            share = np.nanmean(own[:, layer]) / tracked[known].mean()
            if share < CLEAR_SHARE:
                continue
            power_db = decibels(tracked)
            deviation = np.where(known, power_db - power_db[known].mean(), 0)
            square = min(share, 1.0) ** 2
            for row, lag in zip(products[min(layer, 1)], ALL_LAGS, strict=True):
                product = deviation[: BLOCK_LINES - lag] @ deviation[lag:]
                n = (known[: BLOCK_LINES - lag] & known[lag:]).sum()
                row += [product / (square if lag else 1), n]
    return products


def fading(products, speckle):
    """Standard deviation [dB], 1/e length [lines] and exponent of fading, (3,), or NaN.

    Of one kind of interface, from its products by lag (lag, sum and number). ``C(h) = s^2 exp(-(h
    / l)^p)`` at lags of one line and more, less what subtracting a block's mean removes: at lag h
    twice the mean of ``c_i = sum_j C(i - j) / n`` over the pairs' lines i, less its mean over all n
    lines of a block. The excess at lag 0 is `speckle` [dB^2].
    """
    total, n = products.T
    if n.min() < BLOCK_LINES * FEWEST_BLOCKS or total[0] <= 0:
        return np.full(3, np.nan)
    covariance = total / n

    def misfit(parameters):
        variance, length = np.exp(parameters[:2])
        shape = np.exp(-((np.arange(1, BLOCK_LINES) / length) ** parameters[2]))
        kernel = variance * np.insert(shape, 0, 1.0)
        above = np.cumsum(kernel)
        with_mean = (above + above[::-1] - kernel[0]) / BLOCK_LINES
        below = np.cumsum(with_mean[::-1])[::-1]
        removed = 2 * below[ALL_LAGS] / (BLOCK_LINES - ALL_LAGS) - with_mean.mean()
        expected = kernel[ALL_LAGS] - removed - speckle / BLOCK_LINES
        return (expected - covariance)[1:] * np.sqrt(n[1:] / n[1])

    lower = [np.log(1e-4), 0.0, 0.3]
    upper = [np.log(1e3), np.log(4.0 * BLOCK_LINES), 2.0]
    guess = [np.log(max(covariance[1], 1e-3)), np.log(30.0), 1.5]
    guess = np.clip(guess, lower, upper)
    fit = least_squares(misfit, guess, bounds=(lower, upper), **TO_THE_LAST_DIGITS)
    log_variance, log_length, exponent = fit.x
    return np.array([np.exp(log_variance / 2), np.exp(log_length), exponent])
