"""Speckle, against Gamma(M), down range in the air and in along-track spectra.

Fading of layers along track.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.special import betaincinv

from snowsim.constants import BLOCK_LINES
from snowsim.limits import check_count
from snowsim.rounding import rounded
from snowsim.statistics.moments import SPECTRUM_BITS, TO_THE_LAST_DIGITS, decibels
from snowsim.statistics.summaries import GROUP_LINES, stacked

MOST_LOOKS = 1e6  # stands for power without speckle
SPECKLE_LAGS = 9  # range bins: a range response is 2 to 4 of them long
MINIMUM_PAIRS = 10_000  # of bins in the air at every lag: they give a correlation to 0.01
TAIL = np.array([0.001, 0.002, 0.005])
QUANTILES = np.concatenate([TAIL, np.linspace(0.01, 0.99, 99), [0.995, 0.998, 0.999]])
SPECTRUM_LAYERS = 15  # the mean spectrum is that of layers 1 to 15, as in Fig. 8 of the paper
# Fading: autocovariance of power in dB, extrapolated from lags of one line and more to zero.
# Of power on a pick that must be the layer's own, or noise and tails hide its fading.
CLEAR_SHARE = 0.5
FADING_LAGS = np.array([1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96])
ALL_LAGS = np.append(0, FADING_LAGS)
FEWEST_BLOCKS = 4


@dataclass(frozen=True)
class Looks:
    """Looks that fit tracked power, and its quantiles beside those of the law."""

    n_looks: float
    standard_error: float
    probability: np.ndarray
    tracked_quantile: np.ndarray
    gamma_quantile: np.ndarray


def compare_with_gamma(tracked):
    """`Looks` of tracked power.

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
    by_group = ratio.var(axis=1)
    error = by_group.std(ddof=1) / np.sqrt(len(by_group))
    # Without speckle the variance is rounding alone; the law is then a single value.
    variance = max(by_group.mean(), others / (GROUP_LINES * MOST_LOOKS + 1))
    n_looks = max(others / variance - 1, 1e-3) / GROUP_LINES
    return Looks(
        n_looks,
        standard_error=others / variance**2 * error / GROUP_LINES,
        probability=QUANTILES,
        tracked_quantile=np.quantile(ratio, QUANTILES),
        gamma_quantile=GROUP_LINES * betaincinv(n_looks, others * n_looks, QUANTILES),
    )


@dataclass(frozen=True)
class RangeCorrelation:
    """Autocorrelation of speckle down range, its standard error, and its source."""

    correlation: np.ndarray  # (speckle_lag,), from lag 0
    standard_error: np.ndarray
    source: str


def range_correlation(summary):
    """`RangeCorrelation` of power in the air.

    Noise and echoes pass the same range response, so speckle has the correlation of noise.
    Subtracting means leaves an offset that is the same at every lag, read off lags from
    `SPECKLE_LAGS` on. The error is from the scatter of groups. With fewer than `MINIMUM_PAIRS`
    pairs at a lag, as in few images, or without speckle, bins are taken as independent: zero from
    lag 1 on, without an error; the source says ``none``.
    """
    products = stacked(summary, "air_products").astype(float)
    pairs = stacked(summary, "air_pairs").astype(float)
    n_pairs = pairs.sum(axis=0)
    if n_pairs.min() < MINIMUM_PAIRS:
        return _independent(f"fewer than {MINIMUM_PAIRS} pairs of range bins in the air")
    covariance = products.sum(axis=0) / n_pairs
    common = covariance[SPECKLE_LAGS:].mean()
    variance = covariance[0] - common
    if variance < 1 / MOST_LOOKS:
        return _independent("no speckle in the air")
    correlation = (covariance[:SPECKLE_LAGS] - common) / variance
    # What each group adds to the estimate, linearised: to covariances, then to their ratio.
    by_group = (products - covariance * pairs) / n_pairs
    offset = by_group[:, SPECKLE_LAGS:].mean(axis=1, keepdims=True)
    by_group = by_group[:, :SPECKLE_LAGS] - offset
    by_group = (by_group - correlation * by_group[:, :1]) / variance
    n_groups = int((pairs[:, -1] > 0).sum())
    squares = (by_group**2).sum(axis=0)
    error = np.sqrt(squares * n_groups / max(n_groups - 1, 1))
    return RangeCorrelation(correlation, error, "air")


def _independent(reason):
    """Range bins that share no speckle."""
    independent = np.eye(1, SPECKLE_LAGS)[0]
    return RangeCorrelation(independent, np.zeros(SPECKLE_LAGS), f"none: {reason}")


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


def detected_power_spectra(summary):
    """Along-track spectrum of detected power under the picks, for files without phase.

    Two (wavenumber,) or None, of layer 1 and on average over layers 1 to `SPECTRUM_LAYERS`: power
    spectral density of power over its block mean, about the mean, over its own mean [1]: 1
    everywhere where lines are independent. Blocks with a gap are left out for that layer; None
    where no block is whole.
    """
    first, spectra = None, []
    n_layers = max(len(frame.tracked_power) for frame in summary)
    for layer in range(1, min(SPECTRUM_LAYERS + 1, n_layers)):
        frames = [frame for frame in summary if len(frame.tracked_power) > layer]
        blocks = np.concatenate([_whole_blocks(frame.tracked_power[layer]) for frame in frames])
        relative = blocks / blocks.mean(axis=1, keepdims=True)
        density = np.abs(np.fft.rfft(relative)[:, 1:]) ** 2
        if not density.any():
            continue
        mean = density.mean(axis=0)
        spectrum = np.append(0, mean / mean.mean())
        spectra.append(spectrum)
        first = spectrum if layer == 1 else first
    return first, np.mean(spectra, axis=0) if spectra else None


def _whole_blocks(power):
    """Blocks of power (range_line,) without gaps, float64 (block, line of the block)."""
    n_blocks = power.size // BLOCK_LINES
    blocks = power[: n_blocks * BLOCK_LINES].reshape(n_blocks, BLOCK_LINES).astype(float)
    return blocks[np.isfinite(blocks).all(axis=1) & (blocks > 0).any(axis=1)]


def fading_products(summary, powers, frame_of):
    """Products of dB power along track by lag.

    By (frame, surface or buried, lag 0 and others, sum and weights). From whole blocks of tracked
    power about their mean, without gaps. Noise and tails do not fade with a layer: blocks in which
    it has less than `CLEAR_SHARE` of the power on its picks are left out; in the others, products
    at lags of one and more are divided by the square of that share. The last weight is the sum of
    those squares.
    """
    products = np.zeros((len(summary), 2, ALL_LAGS.size, 3))
    groups_in_block = BLOCK_LINES // GROUP_LINES
    for i, frame in enumerate(summary):
        of_frame = powers[frame_of == i]
        n_lines = frame.tracked_power.shape[1]
        for layer in range(min(len(frame.tracked_power), powers.shape[1])):
            interface = min(layer, 1)
            for start in range(0, n_lines - BLOCK_LINES + 1, BLOCK_LINES):
                tracked = frame.tracked_power[layer, start : start + BLOCK_LINES].astype(float)
                first = start // GROUP_LINES
                own = of_frame[first : first + groups_in_block, layer]
                products[i, interface] += _block_products(tracked, own)
    return products


def _block_products(tracked, own):
    """Products of one layer in one block by lag, (lag, sum and weights).

    They are 0 where its fading is not seen.
    """
    known = tracked > 0
    seen = np.isfinite(own)
    if 2 * known.sum() < BLOCK_LINES or not seen.any():
        return 0.0
    share = np.nanmean(own) / tracked[known].mean()
    if share < CLEAR_SHARE:
        return 0.0
    power_db = decibels(tracked)
    deviation = np.where(known, power_db - power_db[known].mean(), 0)
    square = min(share, 1.0) ** 2
    products = np.empty((ALL_LAGS.size, 3))
    for row, lag in zip(products, ALL_LAGS, strict=True):
        product = deviation[: BLOCK_LINES - lag] @ deviation[lag:]
        n = (known[: BLOCK_LINES - lag] & known[lag:]).sum()
        row[:] = product / (square if lag else 1), n, n * square
    return products


@dataclass(frozen=True)
class Fading:
    """Standard deviation, 1/e length and exponent of fading, and nugget.

    By default there is none.
    """

    fading_spread_db: float = 0.0
    fading_length_lines: float = 1.0
    fading_exponent: float = 1.0
    fading_nugget_db2: float = 0.0


def fading(products, speckle):
    """`Fading` of one kind of interface, from its products by lag (lag, sum and weights).

    ``C(h) = s^2 exp(-(h / l)^p)`` at lags of one line and more, less what subtracting a block's
    mean removes: at lag h twice the mean of ``c_i = sum_j C(i - j) / n`` over the pairs' lines i,
    less its mean over all n lines of a block. The excess at lag 0 is the nugget: speckle.
    """
    total, n, n_clear = products.T
    if n.min() < BLOCK_LINES * FEWEST_BLOCKS or total[0] <= 0:
        return Fading(np.nan, np.nan, np.nan, np.nan)
    covariance = total / n

    def expected(parameters):
        variance, length = np.exp(parameters[:2])
        exponent = parameters[2]
        shape = np.exp(-((np.arange(1, BLOCK_LINES) / length) ** exponent))
        kernel = variance * np.insert(shape, 0, 1.0)
        above = np.cumsum(kernel)
        with_mean = (above + above[::-1] - kernel[0]) / BLOCK_LINES
        below = np.cumsum(with_mean[::-1])[::-1]
        removed = 2 * below[ALL_LAGS] / (BLOCK_LINES - ALL_LAGS) - with_mean.mean()
        return kernel[ALL_LAGS] - removed - speckle / BLOCK_LINES

    def misfit(parameters):
        return (expected(parameters) - covariance)[1:] * np.sqrt(n[1:] / n[1])

    lower = [np.log(1e-4), 0.0, 0.3]
    upper = [np.log(1e3), np.log(4.0 * BLOCK_LINES), 2.0]
    guess = [np.log(max(covariance[1], 1e-3)), np.log(30.0), 1.5]
    guess = np.clip(guess, lower, upper)
    fit = least_squares(misfit, guess, bounds=(lower, upper), **TO_THE_LAST_DIGITS)
    log_variance, log_length, exponent = fit.x
    explained = expected(fit.x)[0] * n_clear[0] / n[0]
    return Fading(
        fading_spread_db=np.exp(log_variance / 2),
        fading_length_lines=np.exp(log_length),
        fading_exponent=exponent,
        fading_nugget_db2=covariance[0] - explained,
    )
