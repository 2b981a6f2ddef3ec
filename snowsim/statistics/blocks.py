"""Thickness in blocks of 256 range lines.

Means, trends, spectra, noise of picks, and correlation from slab to slab.
"""

from functools import lru_cache

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import detrend
from scipy.signal.windows import hann

from snowsim.constants import BLOCK_LINES
from snowsim.statistics.moments import mean_where

# Bands of wavenumber [cycles per block]: undulations of kilometres persist from slab to slab,
# decametre drift does not.
BAND_EDGES = np.array([1, 3, 9, 27, BLOCK_LINES // 2 + 1])
MINIMUM_PAIRS = 4  # (block, slab) pairs needed to estimate the correlation at a separation
MOST_SWEEPS = 200
LEVEL_TOLERANCE = 1e-12  # of the logarithm of thickness
# Per block: what follows along track comes from the longest stretches of which enough have no gap.
STRETCHES = (1, 2, 4, 8, 16)
ENOUGH_FOR_TRENDS = 0.1  # of the number of blocks
# Of the number of (block, slab) with picks: every slab has a spectrum, neighbours a correlation.
ENOUGH_FOR_SPECTRA = 0.25
# [cycles per line] above it, picked layers are not known to undulate: what is there is noise.
NOISE_WAVENUMBER = 0.375
# Standard errors above which pick noise is accepted: with few blocks, two occur by chance.
SURE = 3.0
# A spectrum ends where its mean over 7 wavenumbers is below 1.5 times the pick noise: with 4
# stretches, whose tapered ordinates correlate in pairs, that mean scatters by a quarter for noise
# alone.
NOISE_SMOOTHING = 7
CLEARANCE = 1.5
# Of a band's largest density, below which wavenumbers do not count for its correlation.
FAINT = 1e-3


def thickness_blocks(summary, n_layers):
    """Slab thickness in the whole blocks of all frames, (block, slab, range_line), NaN in gaps."""
    blocks = []
    for frame in summary:
        n_blocks = frame.depth_bins.shape[1] // BLOCK_LINES
        n_lines = n_blocks * BLOCK_LINES
        held = frame.depth_bins[:n_layers, :n_lines]
        depth = np.full((n_layers, n_lines), np.nan)
        depth[: len(held)] = held
        thickness = np.diff(depth, axis=0)
        by_slab = thickness.reshape(n_layers - 1, n_blocks, BLOCK_LINES)
        blocks.append(by_slab.swapaxes(0, 1))
    return np.concatenate(blocks)


def block_means(thickness):
    """Mean thickness by block and slab, (block, slab), over the lines that have it.

    NaN where fewer than half do.
    """
    known = np.isfinite(thickness)
    often = 2 * known.sum(axis=2) >= thickness.shape[2]
    return np.where(often, mean_where(known, thickness, axis=2), np.nan)


def block_levels(mean):
    """Mean thickness of slab 0 in every block [bins], and whether slab 0 was picked, two (block,).

    From block means (block, slab), NaN where not picked. Where slab 0 is missing, thickness is
    modelled as the block's level times the slab's factor: both follow by least squares of the
    logarithms, in alternating sweeps that start from blocks with slab 0. NaN for a block that
    shares no slab with the others.
    """
    known = np.isfinite(mean)
    own = known[:, 0]
    logarithm = np.log(np.where(known, mean, 1))
    picked = np.where(own, logarithm[:, 0], np.nan)
    level = picked
    for _ in range(MOST_SWEEPS):
        before = level
        placed = known & np.isfinite(level)[:, None]
        factor = mean_where(placed, logarithm - level[:, None], axis=0)
        rated = known & np.isfinite(factor)
        level = np.where(own, picked, mean_where(rated, logarithm - factor, axis=1))
        if np.allclose(level, before, rtol=0, atol=LEVEL_TOLERANCE, equal_nan=True):
            break
    return np.exp(level), own


def for_trends(thickness, minimum):
    """Stretches (stretch, slab, range_line) of which a tenth of the number of blocks are whole."""
    return stretches(thickness, max(minimum, ENOUGH_FOR_TRENDS * len(thickness)))


def for_spectra(thickness, minimum, finest_lines=None):
    """Stretches of which as many are whole as a quarter of the (block, slab) that have picks.

    So shorter than those for trends where picks have gaps, but at least `finest_lines` long.
    """
    n_picked = np.isfinite(thickness).any(axis=2).sum()
    enough = max(minimum, ENOUGH_FOR_SPECTRA * n_picked)
    return stretches(thickness, enough, shortest=finest_lines or 0)


def stretches(thickness, enough, *, shortest=0):
    """Thickness (block, slab, range_line) cut into stretches of which `enough` have no gap.

    Whole blocks if so many of their series, over all slabs, have none; otherwise halves, quarters
    ... of blocks, down to sixteenths, or to `shortest` lines.
    """
    n_blocks, n_slabs, n_lines = thickness.shape
    for parts in STRETCHES:
        length = n_lines // parts
        cut = thickness.reshape(n_blocks, n_slabs, parts, length).swapaxes(1, 2)
        cut = cut.reshape(n_blocks * parts, n_slabs, length)
        n_whole = np.isfinite(cut).all(axis=2).sum()
        if n_whole >= enough or length < 2 * shortest:
            break
    return cut


@lru_cache(maxsize=8)
def taper_of(n_lines):
    """Hann taper, and half the expected periodogram of a tapered white series of variance 1."""
    taper = hann(n_lines + 2)[1:-1]
    impulses = detrend(np.eye(n_lines), axis=0)
    response = np.fft.rfft(impulses * taper[:, None], axis=0)
    return taper, (np.abs(response) ** 2).sum(axis=1) / n_lines


def fourier(series, tapered):
    """Transform along the last axis, (..., wavenumber), the root of what `periodogram` gives.

    About the mean; if `tapered`, about the least-squares line under a Hann taper, each wavenumber
    scaled so that white series keep their density. A plain transform leaks as k^-2; a tapered one
    recovers densities as steep as k^-6 within .4 dB from two cycles on. At the lowest cycle, the
    line removes up to .7 dB more if spectra are steep.
    """
    n = series.shape[-1]
    if not tapered:
        anomaly = series - series.mean(axis=-1, keepdims=True)
        return np.fft.rfft(anomaly) * np.sqrt(2 / n)
    taper, white = taper_of(n)
    spectrum = np.fft.rfft(detrend(series) * taper)
    return spectrum * np.sqrt(2 / n / np.where(white > 0, white, np.inf))


def periodogram(series, *, tapered=False):
    """One-sided power spectral density along the last axis, about the mean, per cycle per line.

    ``P_k = 2 |X_k|^2 / N`` (without the 2 at the Nyquist wavenumber), so that ``sum_k P_k / N`` is
    the variance; no window, NaN in, NaN out. `tapered`: see `fourier`.
    """
    density = np.abs(fourier(series, tapered)) ** 2
    density[..., 0] = 0
    if series.shape[-1] % 2 == 0:
        density[..., -1] /= 2
    return density


def on_wavenumbers(density, n_lines):
    """Density of shorter stretches at the wavenumbers of `n_lines`.

    Linear between, constant below the lowest.
    """
    n = 2 * (density.shape[-1] - 1)
    if n == n_lines:
        return density
    # The Nyquist wavenumber has half a density: of the short stretches, then of the long ones.
    density[..., -1] *= 2
    held = np.arange(1, n // 2 + 1) / n
    wanted = np.arange(n_lines // 2 + 1) / n_lines
    finer = np.apply_along_axis(lambda row: np.interp(wanted, held, row[1:]), -1, density)
    finer[..., 0] = 0
    finer[..., -1] /= 2
    return finer


def rises(series):
    """Change from the first line to the last of the least-squares line, (...).

    Of series without gaps.
    """
    last = series.shape[-1] - 1
    line = np.arange(series.shape[-1]) - last / 2
    return series @ line / (line @ line) * last


def pick_noise(series, served, minimum):
    """Variance of the noise of each layer's picks and its standard error, two (layer,) [bins^2].

    From stretches (stretch, slab, range_line) that are `served` (stretch, slab). Noise of a layer's
    picks thickens the slab above and thins the one below: its density is minus the real part of
    their cross-spectrum above `NOISE_WAVENUMBER`, taken as white. The first and last layer, and
    those of fewer than `minimum`, take the mean.
    """
    n_layers = served.shape[1] + 1
    spectrum = fourier(np.where(served[..., None], series, 0), True)
    first = int(np.ceil(NOISE_WAVENUMBER * series.shape[-1]))
    high = spectrum[..., first:-1]
    cross = high[:, :-1] * high[:, 1:].conj()
    # One-sided: white noise of variance s^2 has the density 2 s^2.
    products = -cross.real.mean(axis=2) / 2
    both = served[:, :-1] & served[:, 1:]
    noise = np.zeros(n_layers)
    error = np.zeros(n_layers)
    for layer in range(n_layers):
        values = products[both]
        if 0 < layer < n_layers - 1:
            own = both[:, layer - 1]
            values = products[own, layer - 1] if own.sum() >= minimum else values
        if values.size >= minimum:
            noise[layer] = values.mean()
            error[layer] = values.std(ddof=1) / np.sqrt(values.size)
    return np.where(noise > SURE * error, noise, 0.0), error


def without_noise(density, noise):
    """Density (..., wavenumber) less a noise density.

    It is zero from the wavenumber where noise is two thirds of it.
    """
    smooth = uniform_filter1d(density, NOISE_SMOOTHING, axis=-1, mode="nearest")
    lost = smooth < CLEARANCE * noise
    lost[..., 0] = False
    beyond = np.logical_or.accumulate(lost, axis=-1)
    return np.where(beyond, 0.0, np.maximum(density - noise, 0.0))


def undulation_correlation(series, served, density, *, tapered):
    """Correlation between slabs of thickness about its trend, or mean, (band, separation).

    From the stretches (stretch, slab, range_line) that are `served` (stretch, slab). Dividing by
    the expected `density` (stretch, slab, wavenumber), 0 where unknown, weights all equally; those
    30 dB below their band's are left out.
    """
    spectrum = fourier(np.where(served[..., None], series, 0), tapered)
    edges = BAND_EDGES * series.shape[-1] // BLOCK_LINES
    rows = []
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        first = max(low, 1)
        band = slice(first, max(high, first + 1))
        expected = density[..., band]
        usable = expected > FAINT * expected.max(axis=-1, keepdims=True)
        scale = np.sqrt(np.where(usable, expected, np.inf))
        rows.append(correlation_by_separation(spectrum[..., band] / scale))
    return np.array(rows)


def mean_correlation(relative, zone, minimum):
    """Correlation between slabs of relative block means about those of their zone, (separation,).

    From relative means (block, slab). A zone needs `minimum` blocks of a slab for a mean. Slab 0 is
    1 by definition and is left out.
    """
    anomaly = np.zeros(relative.shape)
    for z in np.unique(zone):
        for slab in range(1, relative.shape[1]):
            held = np.isfinite(relative[:, slab]) & (zone == z)
            if held.sum() >= minimum:
                values = relative[held, slab]
                deviation = values.std() or 1
                anomaly[held, slab] = (values - values.mean()) / deviation
    correlation = correlation_by_separation(anomaly[:, 1:, None])
    last = correlation[-1:] if correlation.size else 1.0
    return np.append(correlation, last)


def correlation_by_separation(values):
    """Mean correlation of (block, slab, sample) at separations in slabs, (separation,).

    Absent samples are 0. A separation with fewer than `MINIMUM_PAIRS` (block, slab) pairs takes the
    value of the one before, the first 0.
    """
    n_slabs = values.shape[1]
    # Of separation 0 it is 1, set last: until then its 0 stands in at separation 1.
    correlation = np.zeros(n_slabs)
    squares = (np.abs(values) ** 2).sum(axis=2)
    for separation in range(1, n_slabs):
        above = squares[:, : n_slabs - separation]
        below = squares[:, separation:]
        both = (above > 0) & (below > 0)
        if both.sum() < MINIMUM_PAIRS:
            correlation[separation] = correlation[separation - 1]
            continue
        cross = values[:, : n_slabs - separation] * values[:, separation:].conj()
        product = cross.real.sum(axis=2)[both].sum()
        correlation[separation] = product / np.sqrt(above[both].sum() * below[both].sum())
    correlation[:1] = 1
    return correlation
