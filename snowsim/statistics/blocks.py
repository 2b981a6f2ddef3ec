"""Thickness in blocks of 256 range lines: block means, spectra, and their correlation from slab to slab."""

import numpy as np

from snowsim.constants import BLOCK_LINES

# Bands of wavenumber [cycles per block]: undulations of kilometres persist from slab to slab, decametre drift does not.
BAND_EDGES = np.array([1, 3, 9, 27, BLOCK_LINES // 2 + 1])
MINIMUM_PAIRS = 4  # blocks and slabs that tell the correlation at a separation
MOST_SWEEPS = 200
LEVEL_TOLERANCE = 1e-12  # of the logarithm of thickness
SPECTRAL_SHARES = (1.0, 0.9, 0.5)  # of lines picked, that a block needs for a spectrum: the first with enough blocks
ENOUGH_SHARE = 0.1  # of the number of blocks


def thickness_blocks(summary, n_layers):
    """Slab thickness in the whole blocks of all frames, float64 (block, slab, range_line), NaN in gaps."""
    parts = []
    for frame in summary:
        n_blocks = frame.depth_bins.shape[1] // BLOCK_LINES
        depth = np.full((n_layers, n_blocks * BLOCK_LINES), np.nan)
        held = frame.depth_bins[:n_layers, : n_blocks * BLOCK_LINES]
        depth[: len(held)] = held
        parts.append(np.diff(depth, axis=0).reshape(n_layers - 1, n_blocks, BLOCK_LINES).swapaxes(0, 1))
    return np.concatenate(parts)


def block_means(thickness):
    """Mean thickness by block and slab, (block, slab), over the lines that have it; NaN where fewer than half do."""
    known = np.isfinite(thickness)
    n = known.sum(axis=2)
    mean = np.where(known, thickness, 0).sum(axis=2) / np.maximum(n, 1)
    return np.where(2 * n >= thickness.shape[2], mean, np.nan)


def block_levels(mean):
    """Mean thickness of slab 0 in every block, (block,) [bins], and whether slab 0 was picked there, bool (block,).

    From block means (block, slab), NaN where not picked. Where slab 0 is missing, thickness is taken as a level of the
    block times a factor of the slab: both follow by least squares of the logarithms, in alternating sweeps from the
    blocks that do have slab 0. NaN for a block that shares no slab with the others.
    """
    known = np.isfinite(mean)
    own = known[:, 0]
    logarithm = np.log(np.where(known, mean, 1))
    level = np.where(own, logarithm[:, 0], np.nan)
    for _ in range(MOST_SWEEPS):
        placed = known & np.isfinite(level)[:, None]
        factor = _mean_where(placed, logarithm - level[:, None], axis=0)
        rated = known & np.isfinite(factor)
        swept = np.where(own, logarithm[:, 0], _mean_where(rated, logarithm - factor, axis=1))
        settled = np.array_equal(np.isnan(swept), np.isnan(level))
        settled = settled and np.nanmax(np.abs(swept - level), initial=0) < LEVEL_TOLERANCE
        level = swept
        if settled:
            break
    return np.exp(level), own


def spectral_blocks(thickness, minimum):
    """Thickness (block, slab, range_line) with NaN where no spectrum can be taken, and the number of series closed.

    Blocks without gaps serve if there are `minimum` of them, over all slabs, and a tenth of the number of blocks. In
    short images of layers that come and go there are not: then blocks with nine lines in ten, or else with half of
    them, gaps closed by straight lines between the picks beside them, at the ends by the last pick. Closing takes from
    scales shorter than a gap at most the share of lines closed; long gaps at the ends put some of it, measured to 18 %,
    into the first two wavenumbers.
    """
    share = np.isfinite(thickness).mean(axis=2)
    enough = max(minimum, ENOUGH_SHARE * len(share))
    needed = next((part for part in SPECTRAL_SHARES if (share >= part).sum() >= enough), SPECTRAL_SHARES[-1])
    served = share >= needed
    closed = np.where(served[..., None], thickness, np.nan)
    line = np.arange(thickness.shape[2])
    for block, slab in np.argwhere(served & (share < 1)):
        known = np.isfinite(thickness[block, slab])
        closed[block, slab] = np.interp(line, line[known], thickness[block, slab, known])
    return closed, int((served & (share < 1)).sum())


def periodogram(series):
    """One-sided power spectral density along the last axis, about the mean, per cycle per line.

    ``P_k = 2 |X_k|^2 / N`` (without the 2 at the Nyquist wavenumber), so that ``sum_k P_k / N`` is the variance; no
    window. NaN in, NaN out.
    """
    n = series.shape[-1]
    spectrum = np.fft.rfft(series - series.mean(axis=-1, keepdims=True))
    density = 2 * np.abs(spectrum) ** 2 / n
    density[..., 0] = 0
    if n % 2 == 0:
        density[..., -1] /= 2
    return density


def _mean_where(held, values, axis):
    """Mean of the values held, NaN where there is none."""
    n = held.sum(axis=axis)
    return np.where(n > 0, np.where(held, values, 0).sum(axis=axis) / np.maximum(n, 1), np.nan)


def undulation_correlation(thickness, served, density):
    """Correlation between slabs of thickness about its block mean, (band, separation), by band of wavenumber.

    Of the blocks (block, slab, range_line) that are `served` (block, slab), those without a gap; the expected `density`
    (block, slab, wavenumber) makes wavenumbers weigh the same.
    """
    deviation = np.where(served[..., None], thickness - thickness.mean(axis=2, keepdims=True), 0)
    spectrum = np.fft.rfft(deviation) / np.sqrt(np.where(density > 0, density, np.inf))
    bands = zip(BAND_EDGES[:-1], BAND_EDGES[1:], strict=True)
    return np.array([correlation_by_separation(spectrum[..., low:high]) for low, high in bands])


def mean_correlation(relative, zone, minimum):
    """Correlation between slabs of relative block means (block, slab) about the mean of their zone, (separation,).

    A zone needs `minimum` blocks of a slab to know its mean. Slab 0 is 1 by definition and says nothing.
    """
    anomaly = np.zeros(relative.shape)
    for z in np.unique(zone):
        for slab in range(1, relative.shape[1]):
            held = np.isfinite(relative[:, slab]) & (zone == z)
            if held.sum() >= minimum:
                values = relative[held, slab]
                anomaly[held, slab] = (values - values.mean()) / (values.std() or 1)
    correlation = correlation_by_separation(anomaly[:, 1:, None])
    return np.append(correlation, correlation[-1:] if correlation.size else 1.0)


def correlation_by_separation(values):
    """Mean correlation of (block, slab, sample) at separations in slabs, (separation,); absent samples are 0.

    A separation seen in fewer than `MINIMUM_PAIRS` blocks and slabs takes the value of the one before, at first 0.
    """
    n_slabs = values.shape[1]
    correlation = np.ones(n_slabs)
    squares = (np.abs(values) ** 2).sum(axis=2)
    for separation in range(1, n_slabs):
        upper, lower = values[:, : n_slabs - separation], values[:, separation:]
        above, below = squares[:, : n_slabs - separation], squares[:, separation:]
        both = (above > 0) & (below > 0)
        if both.sum() >= MINIMUM_PAIRS:
            product = (upper * lower.conj()).real.sum(axis=2)[both].sum()
            correlation[separation] = product / np.sqrt(above[both].sum() * below[both].sum())
        else:
            correlation[separation] = correlation[separation - 1] if separation > 1 else 0
    return correlation
