"""The paper's estimators as printed.

Tracked-bin powers, eq. (2) decay rates and 1/e widths of averaged range lines, and periodograms of
thickness.
"""

import numpy as np
import pandas as pd
from scipy.signal import periodogram

from snowsim.constants import BLOCK_LINES
from snowsim.limits import check_count
from snowsim.statistics.groups import OPEN_END_BINS, powers_of_all_layers
from snowsim.statistics.summaries import FIRST_ROW, known_mean

# The waveform's peak lies up to 6 bins below its Gaussian for variances of 10-15.
PEAK_REACH_BINS = 8
# A slab with fewer series without gaps in a zone takes those of all zones, then the slab above.
MINIMUM_SERIES = 4
SHORTEST = 16  # [range lines] least length of the stretches into which blocks are cut


def paper_waveform(tracked_power, decay, width):
    """Variables of the waveform by layer, by the recipe as printed.

    `tracked_power` (layer,) is the mean power under the picks, 0 for layers without picks; `decay`
    and `width` are those of `measure_groups`. The 1/e width stands for a variance, as in the paper.
    Eq. (2) needs a layer below, so the deepest has no decay rate. A layer without values takes
    those of the layer above, or else below, and is `substituted`.
    """
    picked = tracked_power > 0
    means = pd.DataFrame({"decay": known_mean(decay, axis=0), "width": known_mean(width, axis=0)})
    if len(means) > 1:
        what = "averaged lines whose power falls to 1/e between two layers"
        check_count(what, np.isfinite(decay).sum())
    unknown = means.isna()
    unknown.iloc[-1, 0] = False
    nearest = means.ffill().bfill()
    nearest.iloc[-1, 0] = np.nan
    substituted = ~picked | unknown.any(axis=1)
    return {
        "peak_power": ("layer", powers_of_all_layers(tracked_power, picked)),
        "decay_rate": ("layer", nearest["decay"].to_numpy()),
        "width_bins": ("layer", nearest["width"].to_numpy()),
        "variance_bins2": ("layer", nearest["width"].to_numpy()),
        "offset_bins": ("layer", np.zeros(len(means))),
        "substituted": ("layer", substituted.astype(np.int64)),
    }


def measure_groups(groups):
    """Decay rate [per bin] and 1/e width [bins] of every layer of `Groups`, two (group, layer).

    Yari et al. (2021), eq. (2): ``alpha =
    -log(P_min / P_peak) / b`` with `b` bins from the peak, the largest value within
    `PEAK_REACH_BINS` of the layer and half way to its neighbours, to the minimum before the next
    layer; NaN where either layer is absent or no minimum lies between. The 1/e crossing is
    interpolated linearly; NaN where the power does not fall so far before the minimum.
    """
    present = groups.present
    decay_rate = np.full(present.shape, np.nan)
    width = np.full(present.shape, np.nan)
    rows = np.where(present, np.rint(groups.row) - FIRST_ROW, np.nan)
    above = np.diff(rows, prepend=np.nan)
    below = np.diff(rows, append=np.nan)
    start = np.maximum(rows - np.fmin(PEAK_REACH_BINS, above // 2), 0)
    end = rows + np.where(np.isfinite(below), below, OPEN_END_BINS)
    end = np.minimum(end, groups.power.shape[1] - 1)
    middle = rows + np.minimum(PEAK_REACH_BINS, (end - rows) // 2)
    bounds = np.stack([start, middle, end], axis=2)
    for group, layer in np.argwhere(present):
        line = groups.power[group]
        first, last, end = bounds[group, layer].astype(int)
        window = line[first : last + 1]
        if not np.isfinite(window).any():
            continue
        peak = first + np.nanargmax(window)
        fall = line[peak : end + 1]
        # Rows are means over the lines with picks: those of two close layers may cross.
        if fall.size == 0:
            continue
        lowest = np.nanargmin(fall)
        if np.isfinite(below[group, layer]) and 0 < fall[lowest] < fall[0]:
            decay_rate[group, layer] = -np.log(fall[lowest] / fall[0]) / lowest
        target = fall[0] / np.e
        reached = np.flatnonzero(fall[: lowest + 1] <= target)
        if reached.size:
            at = reached[0]
            width[group, layer] = at - (target - fall[at]) / (fall[at - 1] - fall[at])
    return decay_rate, width


def thickness_spectra(thickness, blocks):
    """`thickness_psd (zone, slab, wavenumber)` of thickness (block, slab, range_line), a variable.

    The spectrum is one-sided, about the mean, per cycle per line: ``P_k = 2 |X_k|^2 / N``, once at
    the Nyquist wavenumber, so that ``sum_k P_k / N`` is the variance. Blocks are cut in halves,
    quarters ... until a tenth as many series as there are blocks, and `MINIMUM_SERIES`, have no
    gap; theirs are interpolated to the wavenumbers of a block. Zero where no series is without
    gaps. Without a window a periodogram leaks: power of slow undulations, and of the trend over a
    block, stands at fast ones, falling as the square of the wavenumber, however smooth layers are.
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
    """Thickness (stretch, slab, range_line): blocks cut so that `enough` stretches have no gap."""
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
