"""How thickness goes together from slab to slab: undulations by band of wavenumber, and block means."""

import numpy as np

from snowsim.statistics.blocks import BLOCK_LINES

# Bands of wavenumber [cycles per block]: undulations of kilometres persist from slab to slab, decametre drift does not.
BAND_EDGES = np.array([1, 3, 9, 27, BLOCK_LINES // 2 + 1])
MINIMUM_PAIRS = 4


def undulation_correlation(thickness, served, density):
    """Correlation of thickness about its mean between slabs, by band of wavenumber and separation in slabs.

    Parameters
    ----------
    thickness : ndarray, (block, slab, range_line)
    served : ndarray of bool, (block, slab)
        Blocks without a gap; others do not count.
    density : ndarray, (block, slab, wavenumber)
        Expected spectrum of each, by which wavenumbers are made to weigh the same.

    Returns
    -------
    ndarray, (band, separation)
    """
    deviation = np.where(served[..., None], thickness - thickness.mean(axis=2, keepdims=True), 0)
    spectrum = np.fft.rfft(deviation) / np.sqrt(np.where(density > 0, density, np.inf))
    bands = zip(BAND_EDGES[:-1], BAND_EDGES[1:], strict=True)
    return np.array([correlation_by_separation(spectrum[..., low:high]) for low, high in bands])


def mean_correlation(relative, zone, minimum):
    """Correlation between slabs of relative block-mean thickness about the mean of its zone, (separation,).

    Parameters
    ----------
    relative : ndarray, (block, slab)
        NaN where missing. Slab 0 is 1 by definition and says nothing.
    zone : ndarray of int, (block,)
    minimum : int
        Blocks of a zone needed to know its mean.
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
