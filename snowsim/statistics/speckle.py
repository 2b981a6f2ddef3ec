"""Speckle, against Gamma(M), down range in the air and in along-track spectra; fading of layers along track."""

import numpy as np
from scipy.optimize import least_squares
from scipy.special import betaincinv

from snowsim.statistics.blocks import BLOCK_LINES
from snowsim.statistics.summaries import GROUP_LINES, stacked

MOST_LOOKS = 1e6  # stands for power without speckle
SPECKLE_LAGS = 9  # range bins: a range response is 2 to 4 of them long
MINIMUM_PAIRS = 10_000  # of bins in the air at every lag: they give a correlation to 0.01
QUANTILES = np.concatenate(
    [[0.001, 0.002, 0.005], np.linspace(0.01, 0.99, 99), [0.995, 0.998, 0.999]]
)
# Fading: autocovariance of power in dB, extrapolated from lags of one line and more to zero.
DB = 10 / np.log(10)
CLEAR_SHARE = (
    0.5  # of power on a pick that must be the layer's own, or noise and tails hide its fading
)
FADING_LAGS = np.array([1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96])
FEWEST_BLOCKS = 4


def compare_with_gamma(tracked):
    """Looks that fit tracked power with their standard error, and probabilities, quantiles seen, quantiles of the law.

    `tracked (group, layer, line of the group)` is linear, NaN in gaps; only layers picked in every
    line of a group count, and fewer than two are refused. Yari et al. (2021) call tracked peak
    power chi-square; the average of M looks is Gamma(M). Each value is divided by the mean of its
    20 lines, which removes changes along track: if all are Gamma(M) of one mean, the quotient is 20
    times a Beta(M, 19 M) of variance ``19 / (20 M + 1)``, and looks (at most `MOST_LOOKS`, for
    power without speckle) and quantiles follow without bias.
    """
    whole = tracked[np.isfinite(tracked).all(axis=2)].astype(float)
    whole = whole[whole.mean(axis=1) > 0]
    if len(whole) < 2:
        msg = f"looks need two groups of {GROUP_LINES} lines without gaps in a layer, got {len(whole)}"
        raise ValueError(msg)
    ratio = whole / whole.mean(axis=1, keepdims=True)
    by_group = ratio.var(axis=1)
    variance, error = by_group.mean(), by_group.std(ddof=1) / np.sqrt(len(by_group))
    # Without speckle the variance is rounding alone; the law is then a single value.
    variance = max(variance, (GROUP_LINES - 1) / (GROUP_LINES * MOST_LOOKS + 1))
    n_looks = max((GROUP_LINES - 1) / variance - 1, 1e-3) / GROUP_LINES
    n_looks_error = (GROUP_LINES - 1) / variance**2 * error / GROUP_LINES
    expected = GROUP_LINES * betaincinv(
        n_looks, (GROUP_LINES - 1) * n_looks, QUANTILES
    )  # of the Beta law
    return n_looks, n_looks_error, QUANTILES, np.quantile(ratio, QUANTILES), expected


def range_correlation(summary):
    """Autocorrelation of power down range in the air, (speckle_lag,) from lag 0, its standard error and its source.

    Noise and echoes pass the same range response, so speckle has the correlation of noise.
    Subtracting means leaves an offset that is the same at every lag, read off lags from
    `SPECKLE_LAGS` on. The error is from the scatter of groups. With fewer than `MINIMUM_PAIRS`
    pairs at a lag, as in few images, or without speckle, bins are taken as independent: zero from
    lag 1 on, without an error; the source says ``none``.
    """
    products, pairs = (
        stacked(summary, name).astype(float) for name in ("air_products", "air_pairs")
    )
    n_pairs = pairs.sum(axis=0)
    independent = np.eye(1, SPECKLE_LAGS)[0]
    if n_pairs.min() < MINIMUM_PAIRS:
        return (
            independent,
            np.zeros(SPECKLE_LAGS),
            f"none: fewer than {MINIMUM_PAIRS} pairs of range bins in the air",
        )
    covariance = products.sum(axis=0) / n_pairs
    common = covariance[SPECKLE_LAGS:].mean()
    variance = covariance[0] - common
    if variance < 1 / MOST_LOOKS:
        return independent, np.zeros(SPECKLE_LAGS), "none: no speckle in the air"
    correlation = (covariance[:SPECKLE_LAGS] - common) / variance
    by_group = (products - covariance * pairs) / n_pairs
    by_group = by_group[:, :SPECKLE_LAGS] - by_group[:, SPECKLE_LAGS:].mean(axis=1, keepdims=True)
    by_group = (by_group - correlation * by_group[:, :1]) / variance
    n_groups = int((pairs[:, -1] > 0).sum())
    return correlation, np.sqrt((by_group**2).sum(axis=0) * n_groups / max(n_groups - 1, 1)), "air"


def doppler_spectra(amplitude, layer_bins, line_spacing_m, *, n_mean_layers=15):
    """Along-track wavenumber spectrum of complex echoes under the picks (Fig. 8 of the paper).

    `amplitude (range_bin, range_line)` is elevation-compensated and undetected, `layer_bins (layer,
    range_line)` the picks; layers with a gap are left out, a gap in layer 1 is refused. Returns the
    two-sided wavenumber [cycles per m], increasing, and power spectral density over its mean of
    layer 1 and on average over layers 1 to `n_mean_layers`.
    """
    layer_bins = np.asarray(layer_bins, dtype=float)
    inside = (
        np.isfinite(layer_bins) & (layer_bins > -0.5) & (layer_bins < len(amplitude) - 0.5)
    ).all(axis=1)
    if layer_bins.shape[0] < 2 or not inside[1]:
        msg = f"layer 1 must be picked inside the image on all {layer_bins.shape[-1]} range lines, is not"
        raise ValueError(msg)
    lines = np.arange(layer_bins.shape[1])
    spectra = []
    for layer in range(1, min(n_mean_layers, layer_bins.shape[0] - 1) + 1):
        if inside[layer]:
            echo = amplitude[np.rint(layer_bins[layer]).astype(int), lines]
            density = np.abs(np.fft.fftshift(np.fft.fft(echo))) ** 2
            spectra.append(density / density.mean())
    wavenumber = np.fft.fftshift(np.fft.fftfreq(lines.size, line_spacing_m))
    return wavenumber, spectra[0], np.mean(spectra, axis=0)


def detected_power_spectra(summary, *, n_mean_layers=15):
    """Along-track spectrum of detected power under the picks, for files without phase: two (wavenumber,) or None.

    Of layer 1 and on average over layers 1 to `n_mean_layers`: power spectral density of power over
    its block mean, about the mean, over its own mean [1]: 1 everywhere where lines are independent.
    Blocks with a gap are left out for that layer; None where no block is whole.
    """
    spectra = {}
    for frame in summary:
        n_blocks = frame.tracked_power.shape[1] // BLOCK_LINES
        for layer in range(1, min(n_mean_layers, frame.tracked_power.shape[0] - 1) + 1):
            power = (
                frame.tracked_power[layer, : n_blocks * BLOCK_LINES]
                .reshape(n_blocks, BLOCK_LINES)
                .astype(float)
            )
            power = power[np.isfinite(power).all(axis=1) & (power > 0).any(axis=1)]
            density = np.abs(np.fft.rfft(power / power.mean(axis=1, keepdims=True))[:, 1:]) ** 2
            spectra.setdefault(layer, []).append(density)
    means = {
        layer: np.concatenate(parts).mean(axis=0)
        for layer, parts in spectra.items()
        if sum(map(len, parts))
    }
    means = {
        layer: np.concatenate([[0], mean / mean.mean()])
        for layer, mean in means.items()
        if mean.mean() > 0
    }
    return means.get(1), np.mean(list(means.values()), axis=0) if means else None


def fading_products(summary, powers, frame_of):
    """Products of dB power along track by lag, (frame, surface or buried, lag 0 and others, sum and weights).

    From whole blocks of tracked power about their mean, without gaps. Noise and tails do not fade
    with a layer: blocks in which it has less than `CLEAR_SHARE` of the power on its picks are left
    out; in the others, products at lags of one and more are divided by the square of that share.
    The last weight is the sum of those squares.
    """
    lags = np.append(0, FADING_LAGS)
    products = np.zeros((len(summary), 2, lags.size, 3))
    for i, frame in enumerate(summary):
        of_frame = powers[frame_of == i]
        n_blocks = frame.tracked_power.shape[1] // BLOCK_LINES
        for layer in range(min(len(frame.tracked_power), powers.shape[1])):
            for block in range(n_blocks):
                line = frame.tracked_power[
                    layer, block * BLOCK_LINES : (block + 1) * BLOCK_LINES
                ].astype(float)
                known = line > 0
                first = block * BLOCK_LINES // GROUP_LINES
                own = of_frame[first : first + BLOCK_LINES // GROUP_LINES, layer]
                if 2 * known.sum() < BLOCK_LINES or not np.isfinite(own).any():
                    continue
                share = np.nanmean(own) / line[known].mean()
                if share < CLEAR_SHARE:
                    continue
                value = DB * np.log(np.where(known, line, 1))
                value = np.where(known, value - value[known].mean(), 0)
                square = min(share, 1.0) ** 2
                for j, lag in enumerate(lags):
                    product = value[: BLOCK_LINES - lag] @ value[lag:]
                    n = (known[: BLOCK_LINES - lag] & known[lag:]).sum()
                    products[i, min(layer, 1), j] += product / (square if lag else 1), n, n * square
    return products


def fading(products, speckle):
    """Standard deviation [dB], 1/e length [lines] and exponent of fading, and nugget [dB^2], from products by lag.

    ``C(h) = s^2 exp(-(h / l)^p)`` at lags of one line and more, less what subtracting a block's
    mean removes: at lag h twice the mean of ``c_i = sum_j C(i - j) / n`` over the pairs' lines i,
    less its mean over all n lines of a block. The excess at lag 0 is the nugget: speckle.
    """
    n = products[:, 1]
    if n.min() < BLOCK_LINES * FEWEST_BLOCKS or products[0, 0] <= 0:
        return np.full(4, np.nan)
    covariance = products[:, 0] / n
    lags = np.append(0, FADING_LAGS)

    def expected(parameters):
        variance, length, exponent = np.exp(parameters[0]), np.exp(parameters[1]), parameters[2]
        kernel = variance * np.exp(-((np.arange(BLOCK_LINES) / length) ** exponent))
        above = np.cumsum(kernel)
        with_mean = (above + above[::-1] - kernel[0]) / BLOCK_LINES
        removed = (
            2 * np.cumsum(with_mean[::-1])[::-1][lags] / (BLOCK_LINES - lags) - with_mean.mean()
        )
        return kernel[lags] - removed - speckle / BLOCK_LINES

    bounds = ([np.log(1e-4), 0.0, 0.3], [np.log(1e3), np.log(4.0 * BLOCK_LINES), 2.0])
    first = np.clip([np.log(max(covariance[1], 1e-3)), np.log(30.0), 1.5], *bounds)
    fit = least_squares(
        lambda p: (expected(p) - covariance)[1:] * np.sqrt(n[1:] / n[1]), first, bounds=bounds
    )
    at_zero = expected(fit.x)[0]
    return np.array(
        [
            np.exp(fit.x[0] / 2),
            np.exp(fit.x[1]),
            fit.x[2],
            covariance[0] - at_zero * products[0, 2] / n[0],
        ]
    )
