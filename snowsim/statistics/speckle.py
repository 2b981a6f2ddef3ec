"""Tracked power against the Gamma law of M looks, and along-track spectra of complex and of detected power."""

import numpy as np
from scipy.special import betaincinv

from snowsim.statistics.summaries import GROUP_LINES

MOST_LOOKS = 1e6  # stands for power without speckle
QUANTILES = np.concatenate([[0.001, 0.002, 0.005], np.linspace(0.01, 0.99, 99), [0.995, 0.998, 0.999]])


def compare_with_gamma(tracked):
    """Looks that fit tracked power, and its quantiles beside those of the law.

    Parameters
    ----------
    tracked : ndarray, (group, layer, line of the group)
        Linear power under the picks; NaN in gaps. Only layers picked in every line of a group count.

    Returns
    -------
    n_looks, standard_error : float
        At most `MOST_LOOKS`, for power without speckle.
    probability, observed, expected : ndarray, (quantile,)
        Power over the mean of its group: quantiles seen, and those of the law.

    Raises
    ------
    ValueError
        If no group holds a layer without gaps.

    Notes
    -----
    Yari et al. (2021) call tracked peak power chi-square; the average of M looks is Gamma(M). Each value is divided by
    the mean of its 20 lines, which takes out brightness along track. If all are Gamma(M) of one mean, the quotient is
    20 times a Beta(M, 19 M) of variance ``19 / (20 M + 1)``: looks and quantiles follow from that without bias.
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
    expected = GROUP_LINES * betaincinv(n_looks, (GROUP_LINES - 1) * n_looks, QUANTILES)  # of the Beta law
    return n_looks, n_looks_error, QUANTILES, np.quantile(ratio, QUANTILES), expected


def doppler_spectra(amplitude, layer_bins, line_spacing_m, *, n_mean_layers=15):
    """Along-track wavenumber spectrum of complex echoes under the picks (Fig. 8 of the paper).

    Parameters
    ----------
    amplitude : ndarray of complex, (range_bin, range_line)
        Elevation-compensated, undetected.
    layer_bins : ndarray, (layer, range_line)
        Picks; layers with a gap are left out.
    line_spacing_m : float
    n_mean_layers : int
        The second spectrum is the mean over layers 1 to this one.

    Returns
    -------
    wavenumber : ndarray, (wavenumber,)
        [cycles per m], increasing, two-sided.
    layer_1, layer_mean : ndarray, (wavenumber,)
        Power spectral density over its mean.

    Raises
    ------
    ValueError
        If layer 1 has a gap or lies outside the image.
    """
    layer_bins = np.asarray(layer_bins, dtype=float)
    inside = (np.isfinite(layer_bins) & (layer_bins > -0.5) & (layer_bins < len(amplitude) - 0.5)).all(axis=1)
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


def detected_power_spectra(summary, block_lines, *, n_mean_layers=15):
    """Along-track spectrum of detected power under the picks, for files without phase.

    Parameters
    ----------
    summary : list of FrameSummary
    block_lines : int
        Lines of a block; blocks with a gap in a layer are left out for that layer.
    n_mean_layers : int
        The second spectrum is the mean over layers 1 to this one.

    Returns
    -------
    layer_1, layer_mean : ndarray, (wavenumber,)
        Power spectral density of power over its block mean, about the mean, over its own mean [1]: 1 everywhere where
        lines are independent. None where no block of the layer is whole.
    """
    spectra = {}
    for frame in summary:
        n_blocks = frame.tracked_power.shape[1] // block_lines
        for layer in range(1, min(n_mean_layers, frame.tracked_power.shape[0] - 1) + 1):
            power = frame.tracked_power[layer, : n_blocks * block_lines].reshape(n_blocks, block_lines).astype(float)
            power = power[np.isfinite(power).all(axis=1) & (power > 0).any(axis=1)]
            density = np.abs(np.fft.rfft(power / power.mean(axis=1, keepdims=True))[:, 1:]) ** 2
            spectra.setdefault(layer, []).append(density)
    means = {layer: np.concatenate(parts).mean(axis=0) for layer, parts in spectra.items() if sum(map(len, parts))}
    means = {layer: np.concatenate([[0], mean / mean.mean()]) for layer, mean in means.items() if mean.mean() > 0}
    return means.get(1), np.mean(list(means.values()), axis=0) if means else None
