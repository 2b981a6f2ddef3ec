"""How the radiometry of a flight varies.

Between blocks, along track, where picks end, and in unpicked snow.
"""

import warnings
from dataclasses import astuple, dataclass

import numpy as np
from scipy.optimize import nnls
from scipy.special import polygamma

from snowsim.constants import BLOCK_LINES
from snowsim.phy.waveform import waveform_exact, waveform_peak
from snowsim.statistics.ends import echoes_below, end_contrasts
from snowsim.statistics.lines import BACKGROUND_RISE
from snowsim.statistics.moments import DB, decibels, jackknife, mean_where
from snowsim.statistics.speckle import Fading, fading, fading_products
from snowsim.statistics.summaries import FIRST_ROW, GROUP_LINES, stacked, stacked_tracked
from snowsim.statistics.texture import texture

MOST_PARTS = 20  # of a flight, left out one at a time for standard errors
FEWEST = 4  # blocks or layers needed to estimate a spread
BACKGROUND_FROM = 8  # [bins] below the surface's pick: closer, its own echo dominates
BACKGROUND_BEYOND = 40  # [bins] below the median of the deepest picks, to which groups are compared
# [bins] e-folding depths of the mean background: sums fit most declines.
LAW_FALLS = (30.0, 100.0, 300.0, 1000.0)
# Of the rise of layers where picks end: those that an annotator can only just see.
END_QUANTILE = 0.25
FEWEST_STRETCHES = 8  # so that two lie below that quantile


@dataclass(frozen=True)
class Spreads:
    """Standard deviations between blocks of 256 lines; by default nothing varies."""

    noise_spread_db: float = 0.0
    surface_to_noise_spread_db: float = 0.0
    common_spread_db: float = 0.0
    layer_spread_db: float = 0.0
    decay_spread: float = 0.0
    background_spread_db: float = 0.0


@dataclass(frozen=True)
class Ends:
    """Echoes below the last pick, and contrast there.

    By default all picks count and no image has a further echo.
    """

    further_spacing_bins: float = 1000.0
    further_rise_db: float = 0.0
    end_contrast_db: float = 0.0


@dataclass(frozen=True)
class Background:
    """Mean power of unpicked snow, coefficients by e-folding depth, (fall,).

    By default there is none.
    """

    background_power: np.ndarray | float = 0.0


def power_on_picks(summary, n_layers, noise_power):
    """Mean tracked power less noise in each averaged line, (group, layer), NaN without a pick."""
    tracked = stacked_tracked(summary)[:, :n_layers]
    return mean_where(np.isfinite(tracked), tracked, axis=2) - noise_power


def radiometry(summary, groups, powers, decay_rate, by_layer, n_looks):
    """Statistics of how radiometry varies, name to (dimensions, values), and names of missing ones.

    From merged summaries, `Groups`, powers (group, layer) above noise and neighbours, decay rates
    of eq. (2) (group, layer), values by layer of either estimator, and the flight's looks. Each has
    a jackknife standard error, from leaving out parts of the flight. A quantity that the flight is
    too short to estimate is set constant, has no error and is missing; then all layers count as
    visible, and no echoes lie below the last pick:

    - `noise_spread_db`, `surface_to_noise_spread_db`: standard deviation between blocks of 256
      lines;
    - `common_spread_db`, `layer_spread_db`: of the power of buried layers in a block about each
      layer's mean over the flight, common to all and each layer's own; `decay_spread` of the
      logarithm of the decay rate, less its scatter within blocks;
    - `fading_spread_db`, `fading_length_lines`, `fading_exponent`, `fading_nugget_db2 (interface)`,
      surface then buried layers, see `fading`; `fading_speckle_db2` is the nugget expected from the
      looks;
    - `end_contrast_db`: rise over the snow above of layers below which none is picked, the lower
      quartile;
    - `line_gain_spread_db`, `texture_variance`, `texture_length_bins`, `texture_length_lines`: see
      `texture`;
    - `background_power (fall)`, mean power of unpicked snow, ``sum_k b_k exp(-depth / fall_k)``,
      and its `background_spread_db`; spacing and height of the echoes that rise out of it below the
      last pick, `further_spacing_bins` and `further_rise_db`.
    """
    n_frames = len(summary)
    frame_of = np.repeat(np.arange(n_frames), [len(frame.power) for frame in summary])
    block_of, block_frame = _blocks(summary)
    unpicked = _unpicked(groups, powers, by_layer)
    blocks = _block_values(summary, powers, decay_rate, unpicked, block_of)
    echoes = echoes_below(groups, block_of, n_looks)
    contrasts = end_contrasts(groups, frame_of)
    _warn_of_few(contrasts)
    terms = stacked(summary, "texture_terms")
    products = fading_products(summary, powers, frame_of)
    speckle = DB**2 * polygamma(1, n_looks)

    # Each of these takes the frames to use, bool (frame,).
    def spreads(held):
        return _spreads(blocks, held[block_frame])

    def ends(held):
        rises_db = contrasts.rise_db[held[contrasts.frame]]
        return _ends(echoes[held[block_frame]], rises_db)

    def texture_of(held):
        return texture(terms[held[frame_of]])

    def fading_of(held):
        by_interface = products[held].sum(axis=0)
        fits = [astuple(fading(of_one, speckle)) for of_one in by_interface]
        return Fading(*np.transpose(fits))

    def background(held):
        return Background(_background_law(unpicked, held[frame_of]))

    part_of = np.arange(n_frames) * min(MOST_PARTS, n_frames) // n_frames
    estimators = {spreads: (), ends: (), texture_of: ()}
    estimators |= {fading_of: "interface", background: "fall"}
    values, errors, missing = {}, {}, []
    for estimator, dims in estimators.items():
        found = jackknife(estimator, part_of)
        values |= {name: (dims, value) for name, value in found.values.items()}
        errors |= {f"{name}_standard_error": (dims, error) for name, error in found.errors.items()}
        missing += found.missing
    return values | errors | {"fading_speckle_db2": ((), speckle)}, missing


def _warn_of_few(contrasts):
    """Warn where `end_contrast_db` stands on few stretches."""
    # Each stretch has one rise, repeated for its averaged lines.
    n_stretches = np.unique(contrasts.rise_db).size
    if 0 < n_stretches < FEWEST_STRETCHES:
        n_frames = np.unique(contrasts.frame).size
        msg = f"end_contrast_db, down to which layers are labelled, stands on {n_stretches} "
        msg += f"stretches of deepest layers in {n_frames} frames, {FEWEST_STRETCHES} are needed"
        warnings.warn(msg, UserWarning, stacklevel=4)


def _blocks(summary):
    """Number of the block of each group, over the flight, -1 beyond the last whole one.

    And the frame of each block.
    """
    numbers, frames = [], []
    for i, frame in enumerate(summary):
        n_groups = len(frame.power)
        # A frame shorter than a block counts as one.
        n_blocks = max(n_groups * GROUP_LINES // BLOCK_LINES, min(n_groups, 1))
        middle = (np.arange(n_groups) + 0.5) * GROUP_LINES
        number = (middle / BLOCK_LINES).astype(int)
        numbers.append(np.where(number < n_blocks, number + len(frames), -1))
        frames += [i] * n_blocks
    return np.concatenate(numbers), np.array(frames, dtype=int)


@dataclass(frozen=True)
class BlockValues:
    """Means of blocks of 256 lines, NaN where fewer than half of the groups have a value."""

    noise_db: np.ndarray  # (block,)
    power_db: np.ndarray  # of layers, (block, layer)
    background_db: np.ndarray  # (block,)
    decays: np.ndarray  # sums of `_block_decays`, (block, 3)


def _block_values(summary, powers, decay_rate, unpicked, block_of):
    air_sum = _block_sums(stacked(summary, "air_sum"), block_of)
    air_count = _block_sums(stacked(summary, "air_count"), block_of)
    background = _block_means(unpicked.mean[:, None], block_of)[:, 0]
    return BlockValues(
        noise_db=decibels(air_sum / np.maximum(air_count, 1)),
        power_db=decibels(_block_means(powers, block_of)),
        background_db=decibels(background),
        decays=_block_decays(decay_rate, block_of),
    )


def _block_sums(values, block_of):
    """Sums over the groups of each block, (block, ...)."""
    total = np.zeros((block_of.max() + 1, *values.shape[1:]))
    whole = block_of >= 0
    np.add.at(total, block_of[whole], values[whole])
    return total


def _block_means(values, block_of):
    """Means over the groups of each block, (block, column).

    NaN where fewer than half have a value.
    """
    known = np.isfinite(values)
    n = _block_sums(known, block_of)
    n_groups = _block_sums(np.ones((len(values), 1)), block_of)
    total = _block_sums(np.where(known, values, 0), block_of)
    return np.where(2 * n >= n_groups, total / np.maximum(n, 1), np.nan)


def _block_decays(decay_rate, block_of):
    """Sums by block of log decay rates about each layer's mean, squares, and count, (block, 3)."""
    logarithm = np.log(np.where(decay_rate > 0, decay_rate, np.nan))
    known = np.isfinite(logarithm)
    usable = known & (known.sum(axis=0) >= 2)
    deviation = np.where(usable, logarithm - mean_where(known, logarithm, axis=0), 0)
    squares = (deviation**2).sum(axis=1)
    sums = np.column_stack([deviation.sum(axis=1), squares, usable.sum(axis=1)])
    return _block_sums(sums, block_of)


def _spreads(blocks, held):
    """`Spreads` between the blocks `held`; NaN where they are too few."""
    noise_db = blocks.noise_db[held]
    power_db = blocks.power_db[held]
    common_db, layer_db = common_and_own_spread(power_db[:, 1:])
    return Spreads(
        noise_spread_db=_deviation(noise_db),
        surface_to_noise_spread_db=_deviation(power_db[:, 0] - noise_db),
        common_spread_db=common_db,
        layer_spread_db=layer_db,
        decay_spread=_decay_spread(blocks.decays[held]),
        background_spread_db=_deviation(blocks.background_db[held]),
    )


def _deviation(values):
    known = values[np.isfinite(values)]
    return known.std(ddof=1) if known.size >= FEWEST else np.nan


def common_and_own_spread(power_db):
    """Standard deviations of dB (block, layer) about each layer's mean.

    Common to a block's layers, and each layer's own beyond that. The mean product of two layers of
    one block is the common variance. Subtracting means over n blocks removes 1 / n.
    """
    n = np.isfinite(power_db).sum(axis=0)
    enough = n >= FEWEST
    if not enough.any():
        return np.nan, np.nan
    n, power_db = n[enough], power_db[:, enough]
    known = np.isfinite(power_db)
    anomaly = np.where(known, power_db - np.nanmean(power_db, axis=0), 0)
    deviation = anomaly * np.sqrt(n / (n - 1))
    squares = (deviation**2).sum()
    total = squares / known.sum()
    n_pairs = (known.sum(axis=1) ** 2).sum() - known.sum()
    if n_pairs < FEWEST:
        return 0.0, np.sqrt(total)
    products = (deviation.sum(axis=1) ** 2).sum() - squares
    common = np.clip(products / n_pairs, 0, total)
    return np.sqrt(common), np.sqrt(total - common)


def _decay_spread(sums):
    """Standard deviation of block means, less the part due to scatter within blocks."""
    total, square, n = sums[sums[:, 2] >= 2].T
    if n.size < FEWEST:
        return np.nan
    mean = total / n
    within = (square - n * mean**2) / (n - 1)
    return np.sqrt(max(mean.var(ddof=1) - (within / n).mean(), 0.0))


def _ends(echoes, rises_db):
    """`Ends` from `echoes_below` of blocks, and the rise of each deepest layer."""
    n_echoes, total_rise_db, n_rows = echoes.sum(axis=0)
    contrast_db = np.quantile(rises_db, END_QUANTILE) if rises_db.size >= FEWEST else np.nan
    if n_echoes == 0:
        return Ends(np.nan, np.nan, contrast_db)
    return Ends(n_rows / n_echoes, total_rise_db / n_echoes, contrast_db)


@dataclass(frozen=True)
class Unpicked:
    """Power that no pick explains, by row from `FIRST_ROW`; 0 where it is not used."""

    mean: (
        np.ndarray
    )  # over the rows that all groups are compared in, (group,), NaN where there is none
    power: np.ndarray  # less noise and picked layers, (group, row)
    total: np.ndarray  # with them, (group, row)
    used: np.ndarray  # bool (group, row)


def _unpicked(groups, powers, by_layer):
    """`Unpicked` power of each group, from below the surface's own echo on."""
    rows = _rows(groups.power)
    left = groups.power - groups.noise_power - _modelled(groups, powers, by_layer)
    below_surface = groups.present[:, :1] & (rows >= BACKGROUND_FROM)
    used = np.isfinite(left) & below_surface
    position = groups.position.mean(axis=2)
    deepest = np.where(groups.present, position, 0).max(axis=1)
    shared = rows <= np.median(deepest) + BACKGROUND_BEYOND
    power = np.where(used, left, 0.0)
    total = np.where(used, groups.power, 0.0)
    return Unpicked(mean_where(used & shared, power, axis=1), power, total, used)


def _rows(power):
    """Rows of averaged lines (group, row), from the surface."""
    return np.arange(power.shape[1]) + FIRST_ROW


def _modelled(groups, powers, by_layer):
    """Power of the picked layers alone, (group, row)."""
    variance = by_layer["variance_bins2"]
    decay = by_layer["decay_rate"]
    known = np.isfinite(decay)
    # The deepest layer of `paper` has none.
    typical = np.median(decay[known]) if known.any() else BACKGROUND_RISE
    decay = np.where(known, decay, typical)
    lead, height = waveform_peak(variance, decay)
    rows = _rows(groups.power)
    position = groups.position.mean(axis=2)
    spread = groups.spread.mean(axis=2) + groups.position.var(axis=2)
    total = np.zeros(groups.power.shape)
    for layer, offset in enumerate(by_layer["offset_bins"]):
        held = np.isfinite(powers[:, layer]) & np.isfinite(position[:, layer])
        wide = variance[layer] + spread[held, layer, None]
        lag = rows - position[held, layer, None] - offset + lead[layer]
        wave = np.sqrt(variance[layer] / wide) * waveform_exact(lag, wide, decay[layer])
        total[held] += powers[held, layer, None] * (wave / height[layer])
    return total


def _background_law(unpicked, held):
    """Coefficients of ``sum_k b_k exp(-depth / fall_k)``, none negative, (fall,).

    From the groups `held`. Least squares of the mean power of unpicked snow, weighted by the
    speckle of all mean power.
    """
    n = unpicked.used[held].sum(axis=0)
    level = unpicked.power[held].sum(axis=0) / np.maximum(n, 1)
    total = unpicked.total[held].sum(axis=0) / np.maximum(n, 1)
    seen = (n >= FEWEST) & (total > 0)
    if seen.sum() < len(LAW_FALLS):
        return np.full(len(LAW_FALLS), np.nan)
    depth = _rows(unpicked.power)[seen]
    scale = total[seen] / np.sqrt(n[seen])
    columns = np.exp(-depth[:, None] / LAW_FALLS) / scale[:, None]
    return nnls(columns, level[seen] / scale)[0]
