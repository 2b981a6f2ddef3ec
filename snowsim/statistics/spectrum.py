"""The paper's undulations of thickness: plain periodograms, by zone and slab.

Without a window a periodogram leaks: power of slow undulations, and of the trend over a block,
stands at fast ones, falling as the square of the wavenumber, however smooth layers are.
"""

import numpy as np
from scipy.signal import periodogram

from snowsim.constants import BLOCK_LINES
from snowsim.statistics.moments import known_mean

MINIMUM_SERIES = 4  # without gaps; a slab of a zone with fewer takes all zones, then the slab above
SHORTEST = 16  # [range lines] of stretches without gaps that blocks are cut into


def thickness_spectra(thickness, blocks):
    """`thickness_psd (zone, slab, wavenumber)` of thickness (block, slab, range_line), a variable.

    The spectrum is one-sided, about the mean, per cycle per line: ``P_k = 2 |X_k|^2 / N``, once at
    the Nyquist wavenumber, so that ``sum_k P_k / N`` is the variance. Blocks are cut in halves,
    quarters ... until a tenth as many series as there are blocks, and `MINIMUM_SERIES`, have no
    gap; theirs are interpolated to the wavenumbers of a block. Zero where no series is without
    gaps.
    """
    series = _stretches(thickness, max(MINIMUM_SERIES, len(thickness) / 10))
    n_parts = len(series) // len(thickness)
    zone = np.repeat(blocks.zone, n_parts)
    level = np.repeat(blocks.level, n_parts)
    whole = np.isfinite(series).all(axis=2)
    wavenumber, density = periodogram(series)
    of_all = known_mean(density / level[:, None, None] ** 2, axis=0)
    n = np.array([whole[zone == z].sum(axis=0) for z in range(blocks.typical.size)])
    own = n >= MINIMUM_SERIES
    known = own | (n.sum(axis=0) >= MINIMUM_SERIES)
    source = np.maximum.accumulate(np.where(known, np.arange(n.shape[1]), 0), axis=1)
    psd = []
    for z, typical in enumerate(blocks.typical):
        of_zone = known_mean(density[zone == z], axis=0)
        of_zone = np.where(own[z, :, None], of_zone, of_all * typical**2)
        psd.append(np.nan_to_num(of_zone[source[z]]))
    psd = np.apply_along_axis(_on_block, 2, psd, wavenumber)
    return {"thickness_psd": (("zone", "slab", "wavenumber"), psd)}


def _stretches(thickness, enough):
    """Thickness (block, slab, range_line) in equal stretches, of which `enough` have no gap."""
    length = thickness.shape[2]
    while True:
        cut = thickness.reshape(*thickness.shape[:2], -1, length).swapaxes(1, 2)
        cut = cut.reshape(-1, thickness.shape[1], length)
        if np.isfinite(cut).all(axis=2).sum() >= enough or length == SHORTEST:
            return cut
        length //= 2


def _on_block(density, wavenumber):
    """Density (wavenumber,) at the wavenumbers of a block, constant below its first, 0 at 0."""
    # Interpolated as if two-sided, in which the Nyquist wavenumber is no exception.
    two_sided = np.append(density[1:-1], 2 * density[-1])
    on_block = np.interp(np.fft.rfftfreq(BLOCK_LINES), wavenumber[1:], two_sided)
    on_block[0] = 0
    on_block[-1] /= 2
    return on_block
