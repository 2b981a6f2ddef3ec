"""The paper's undulations of thickness: plain periodograms, by zone and slab.

Without a window a periodogram leaks: power of slow undulations, and of the trend over a block,
stands at fast ones, falling as the square of the wavenumber, however smooth layers are.
"""

import numpy as np
from scipy.signal import periodogram

from snowsim.constants import BLOCK_LINES

MINIMUM_SERIES = 4  # without gaps; a slab of a zone with fewer takes all zones, then the slab above
SHORTEST = 16  # [range lines] of stretches without gaps that blocks are cut into


def thickness_spectra(thickness, blocks):
    """`thickness_psd` and `n_psd_samples` (zone, slab, ...) of thickness (block, slab, range_line).

    `thickness_psd (zone, slab, wavenumber)` is one-sided, about the mean, per cycle per line:
    ``P_k = 2 |X_k|^2 / N``, once at the Nyquist wavenumber, so that ``sum_k P_k / N`` is the
    variance. Blocks are cut in halves, quarters ... until a tenth as many series as there are
    blocks, and `MINIMUM_SERIES`, have no gap; theirs are interpolated to the wavenumbers of a
    block. Zero where no series is without gaps.
    """
    series = _stretches(thickness, max(MINIMUM_SERIES, len(thickness) / 10))
    n_parts = len(series) // len(thickness)
    zone = np.repeat(blocks.zone, n_parts)
    level = np.repeat(blocks.level, n_parts)
    whole = np.isfinite(series).all(axis=2)
    shape = (blocks.typical.size, series.shape[1])
    psd = np.zeros((*shape, BLOCK_LINES // 2 + 1))
    n = np.zeros(shape, dtype=int)
    np.add.at(n, zone, whole)
    n_in_all = n.sum(axis=0)
    for z, slab in np.ndindex(shape):
        held = whole[:, slab]
        share = np.ones(len(held))
        if n[z, slab] >= MINIMUM_SERIES:
            held = held & (zone == z)
        elif n_in_all[slab] >= MINIMUM_SERIES or slab == 0:
            share = blocks.typical[z] / level
        else:
            psd[z, slab] = psd[z, slab - 1]
            continue
        if held.any():
            density = _density(series[held, slab]) * share[held, None] ** 2
            psd[z, slab] = density.mean(axis=0)
    on = ("zone", "slab")
    return {"thickness_psd": ((*on, "wavenumber"), psd), "n_psd_samples": (on, n)}


def _stretches(thickness, enough):
    """Thickness (block, slab, range_line) in equal stretches, of which `enough` have no gap."""
    length = thickness.shape[2]
    while True:
        cut = thickness.reshape(*thickness.shape[:2], -1, length).swapaxes(1, 2)
        cut = cut.reshape(-1, thickness.shape[1], length)
        if np.isfinite(cut).all(axis=2).sum() >= enough or length == SHORTEST:
            return cut
        length //= 2


def _density(series):
    """Periodograms (series, wavenumber) at the wavenumbers of a block, constant below theirs."""
    wavenumber, density = periodogram(series)
    # Interpolated as two-sided.
    density[:, -1] *= 2
    wanted = np.fft.rfftfreq(BLOCK_LINES)
    on_block = np.array([np.interp(wanted, wavenumber[1:], row[1:]) for row in density])
    on_block[:, 0] = 0
    on_block[:, -1] /= 2
    return on_block
