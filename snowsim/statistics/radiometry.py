"""Variation of a flight's radiometry between blocks and lines, and its unpicked echoes."""

import numpy as np
import pandas as pd
import xarray as xr
from scipy.optimize import nnls
from scipy.signal import find_peaks

from snowsim.constants import BLOCK_LINES
from snowsim.phy.waveform import waveform_exact, waveform_peak
from snowsim.statistics.groups import TYPICAL_DECAY_RATE
from snowsim.statistics.speckle import DB, decibels
from snowsim.statistics.summaries import FIRST_ROW, GROUP_LINES, known_mean, numbered, rows_from

FEWEST = 4  # blocks or layers needed to estimate a spread
FEWEST_GAINS = 20  # groups needed to estimate gain from line to line
BACKGROUND_FROM = 8  # [bins] below the surface's pick; further up its own echo dominates
# [bins] Unpicked power of groups is compared down to this far below the median of deepest picks.
BACKGROUND_BEYOND = 40
# [bins] e-folding depths of the mean background: sums fit most declines.
LAW_FALLS = (30.0, 100.0, 300.0, 1000.0)
BELOW_BINS = 8  # [bins] below the last pick in which its own echo dominates
FEWEST_ROWS = 3  # a peak has a neighbour on either side
PEAK_DEVIATIONS = 4.0  # an unpicked echo rises by this many standard deviations of speckle
# Values for quantities that a flight is too short to estimate, if not zero. With them nothing
# varies, and no image has an echo below the last pick.
CONSTANT = {"further_spacing_bins": 1000.0}


def radiometry(summary, groups, powers, waveform, n_looks):
    """Variables of the variation of radiometry, and names of those not estimated.

    They are estimated from a merged summary, `Groups`, powers (group, layer) above noise and
    neighbours, variables of the waveform by either estimator, and the flight's looks. A missing
    quantity gets its value in `CONSTANT`, or zero.

    - `surface_spread_db`: standard deviation of the surface between blocks of 256 lines, that of
      surface over noise less that of the noise;
    - `common_spread_db`, `layer_spread_db`: of the power of buried layers in a block about each
      layer's mean over the flight, common to all and each layer's own;
    - `line_gain_spread_db`: of gain from line to line;
    - `background_power (fall)`, mean power of unpicked snow, ``sum_k b_k exp(-depth / fall_k)``,
      and its `background_spread_db`; spacing and height of the echoes that rise out of it below the
      last pick, `further_spacing_bins` and `further_rise_db`.
    """
    block = _block_of_groups(summary)
    unpicked, law = _unpicked(groups, powers, waveform)
    air = summary[["air_sum", "air_count"]].to_dataframe().groupby(block).sum()
    noise_db = decibels(air["air_sum"] / air["air_count"])
    power_db = decibels(_block_means(powers, block))
    # Gain that changes from block to block changes both alike.
    surface_db2 = _deviation(power_db[:, 0] - noise_db) ** 2 - _deviation(noise_db) ** 2
    common_db, layer_db = common_and_own_spread(power_db[:, 1:])
    spacing_bins, rise_db = _further(groups, block, n_looks)
    gains = summary["gain_variance"].values
    gain_db = np.nan
    if np.isfinite(gains).sum() >= FEWEST_GAINS:
        gain_db = DB * np.sqrt(max(known_mean(gains), 0))
    variables = {
        "surface_spread_db": np.sqrt(np.maximum(surface_db2, 0)),
        "common_spread_db": common_db,
        "layer_spread_db": layer_db,
        "background_spread_db": _deviation(decibels(_block_means(unpicked, block))),
        "line_gain_spread_db": gain_db,
        "further_spacing_bins": spacing_bins,
        "further_rise_db": rise_db,
        "background_power": ("fall", law),
    }
    found = xr.Dataset(variables)
    missing = [name for name, values in found.items() if values.isnull().any()]
    return found.fillna({name: CONSTANT.get(name, 0.0) for name in missing}), missing


def _block_of_groups(summary):
    """Number of the block of each group, (group,), counted through all frames.

    NaN for groups beyond the last whole block of a frame. A frame shorter than a block counts as
    one block.
    """
    n_groups = summary["n_groups"].values
    n_blocks = np.maximum(n_groups * GROUP_LINES // BLOCK_LINES, np.minimum(n_groups, 1))
    number = (numbered(n_groups) + 0.5) * GROUP_LINES // BLOCK_LINES
    number[number >= np.repeat(n_blocks, n_groups)] = np.nan
    return number + np.repeat(n_blocks.cumsum() - n_blocks, n_groups)


def _block_means(values, block):
    """Means over the groups of each block, (block, ...), NaN if fewer than half have a value."""
    by_block = pd.DataFrame(values).groupby(block)
    often = 2 * by_block.count().to_numpy() >= by_block.size().to_numpy()[:, None]
    return by_block.mean().where(often).to_numpy()


def _deviation(values):
    known = values[np.isfinite(values)]
    return known.std(ddof=1) if known.size >= FEWEST else np.nan


def common_and_own_spread(power_db):
    """Standard deviations of dB (block, layer) about each layer's mean.

    Common to a block's layers, and each layer's own beyond that. The mean product of two layers of
    one block is the common variance. Subtracting means over n blocks removes 1 / n.
    """
    power_db = power_db[:, np.isfinite(power_db).sum(axis=0) >= FEWEST]
    known = np.isfinite(power_db)
    if not known.any():
        return np.nan, np.nan
    n = known.sum(axis=0)
    anomaly = np.where(known, power_db - known_mean(power_db, axis=0), 0)
    deviation = anomaly * np.sqrt(n / (n - 1))
    squares = (deviation**2).sum()
    total = squares / n.sum()
    n_pairs = (known.sum(axis=1) ** 2).sum() - n.sum()
    if n_pairs < FEWEST:
        return 0.0, np.sqrt(total)
    products = (deviation.sum(axis=1) ** 2).sum() - squares
    common = np.clip(products / n_pairs, 0, total)
    return np.sqrt(common), np.sqrt(total - common)


def _further(groups, block, n_looks):
    """Mean spacing [bins] and rise [dB] of echoes in a block's mean profile below its last pick.

    Echoes are peaks that rise out of speckle over the profile beside them; NaN if there are none.
    The last pick is that of the deepest layer that half of a block's averaged lines have.
    """
    rises_db = []
    total_rows = 0
    for number in np.unique(block[np.isfinite(block)]):
        members = np.flatnonzero(block == number)
        often = 2 * groups.present[members].sum(axis=0) >= members.size
        if not often[1:].any():
            continue
        last = np.flatnonzero(often)[-1]
        members = members[groups.present[members, last]]
        first = np.rint(groups.row[members, last]).astype(int) - FIRST_ROW + BELOW_BINS
        lines = rows_from(groups.power[members], first, groups.power.shape[1])
        lines = lines[:, np.isfinite(lines).all(axis=0)].astype(float)
        if lines.shape[1] < FEWEST_ROWS:
            continue
        deviation_db = DB / np.sqrt(n_looks * GROUP_LINES * members.size)
        profile_db = DB * np.log(np.maximum(lines.mean(axis=0), 1e-300))
        _, found = find_peaks(profile_db, prominence=PEAK_DEVIATIONS * deviation_db)
        rises_db.extend(found["prominences"])
        total_rows += lines.shape[1]
    if not rises_db:
        return np.nan, np.nan
    return total_rows / len(rises_db), np.mean(rises_db)


def _unpicked(groups, powers, waveform):
    """Power that no pick explains: mean by group, and coefficients of its law by `LAW_FALLS`.

    Both begin below the surface's own echo. The mean is over the rows in which all groups are
    compared, NaN without any. The law is ``sum_k b_k exp(-depth / fall_k)`` with no b_k negative,
    by least squares of the mean over groups, weighted by the speckle of the mean of all power.
    """
    rows = np.arange(groups.power.shape[1]) + FIRST_ROW
    used = groups.present[:, :1] & (rows >= BACKGROUND_FROM)
    power = np.where(used, groups.power, np.nan).astype(float)
    left = power - groups.noise_power - _picked(groups, powers, waveform, rows)
    deepest = np.where(groups.present, groups.row, 0).max(axis=1)
    shared = rows <= np.median(deepest) + BACKGROUND_BEYOND
    mean = known_mean(left[:, shared], axis=1)
    n = np.isfinite(left).sum(axis=0)
    total = known_mean(power, axis=0)
    seen = (n >= FEWEST) & (total > 0)
    if seen.sum() < len(LAW_FALLS):
        return mean, np.full(len(LAW_FALLS), np.nan)
    scale = total[seen] / np.sqrt(n[seen])
    columns = np.exp(-rows[seen, None] / LAW_FALLS) / scale[:, None]
    return mean, nnls(columns, known_mean(left, axis=0)[seen] / scale)[0]


def _picked(groups, powers, waveform, rows):
    """Power of the picked layers alone, (group, row)."""
    names = ("variance_bins2", "decay_rate", "offset_bins")
    variance, decay, offset = (waveform[name][1] for name in names)
    # The estimator `paper` has no decay rate for the deepest layer.
    typical = np.nanmedian(decay) if decay.size > 1 else TYPICAL_DECAY_RATE
    decay = np.where(np.isfinite(decay), decay, typical)
    lead, height = waveform_peak(variance, decay)
    spread = groups.spread.mean(axis=2) + groups.position.var(axis=2)
    total = np.zeros(groups.power.shape)
    for layer in range(offset.size):
        held = np.isfinite(powers[:, layer]) & np.isfinite(groups.row[:, layer])
        wide = variance[layer] + spread[held, layer, None]
        lag = rows - groups.row[held, layer, None] - offset[layer] + lead[layer]
        wave = np.sqrt(variance[layer] / wide) * waveform_exact(lag, wide, decay[layer])
        total[held] += powers[held, layer, None] * (wave / height[layer])
    return total
