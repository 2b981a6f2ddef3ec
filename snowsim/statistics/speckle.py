"""Speckle: its law, its correlation down range, and its spectra along track."""

import numpy as np
from scipy.special import betaincinv

from snowsim.limits import check_count
from snowsim.seeding import rounded
from snowsim.statistics.summaries import GROUP_LINES, in_blocks, in_stretches, known_mean

DB = 10 / np.log(10)  # decibels in one neper of power
MOST_LOOKS = 1e6  # looks of power without speckle
SPECKLE_LAGS = 9  # range bins: a range response is 2 to 4 of them long
MINIMUM_PAIRS = 10_000  # pairs of bins in the air at every lag: a correlation errs by 0.01
TAIL = np.array([0.001, 0.002, 0.005])
QUANTILES = np.concatenate([TAIL, np.linspace(0.01, 0.99, 99), [0.995, 0.998, 0.999]])
SPECTRUM_BITS = 10  # of Doppler spectra: phases drawn in float32 leave 2e-6
SPECTRUM_LAYERS = 15  # the mean spectrum is that of layers 1 to 15, as in Fig. 8 of the paper


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
