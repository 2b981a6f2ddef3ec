"""How the radiometry of a flight varies: between blocks, along track, where picks end, and in unpicked snow."""

import numpy as np
from scipy.optimize import nnls
from scipy.special import polygamma

from snowsim.phy.waveform import waveform_exact, waveform_peak
from snowsim.statistics.blocks import BLOCK_LINES
from snowsim.statistics.ends import echoes_below, end_contrasts
from snowsim.statistics.lines import BACKGROUND_RISE
from snowsim.statistics.speckle import fading, fading_products
from snowsim.statistics.summaries import FIRST_ROW, GROUP_LINES, stacked, stacked_tracked
from snowsim.statistics.texture import NAMES as TEXTURE
from snowsim.statistics.texture import texture

DB = 10 / np.log(10)
MOST_PARTS = 20  # of a flight, left out one at a time for standard errors
FEWEST = 4  # blocks or layers needed to estimate a spread
BACKGROUND_FROM = 8  # [bins] below the surface's pick: closer, its own echo dominates
LAW_FALLS = (
    30.0,
    100.0,
    300.0,
    1000.0,
)  # [bins] e-folding depths of the mean background: sums fit most declines
NAMES = (
    *(
        "noise_spread_db",
        "surface_to_noise_spread_db",
        "common_spread_db",
        "layer_spread_db",
        "decay_spread",
    ),
    *(
        "background_spread_db",
        "further_spacing_bins",
        "further_rise_db",
        "end_contrast_db",
        *TEXTURE,
    ),
)
END_QUANTILE = (
    0.25  # of the rise of layers where picks end: those that an annotator can only just see
)
# Where the flight is too short: no spread, no echo within an image, all picks count; no texture,
# fading, background.
STAND_INS = (
    [0.0] * 6
    + [1000.0, 0.0, 0.0]
    + [0.0, 0.0, 1.0, 1.0]
    + [0.0, 1.0, 1.0, 0.0] * 2
    + [0.0] * len(LAW_FALLS)
)


def power_on_picks(summary, n_layers, noise_power):
    """Mean tracked power less noise in each averaged line, (group, layer), NaN without a pick."""
    tracked = stacked_tracked(summary)[:, :n_layers]
    known = np.isfinite(tracked)
    n = known.sum(axis=2)
    return np.where(
        n > 0, np.where(known, tracked, 0).sum(axis=2) / np.maximum(n, 1) - noise_power, np.nan
    )


def radiometry(summary, groups, powers, decay_rate, by_layer, n_looks):
    """Statistics of how radiometry varies, name to (dimensions, values), and an attribute that names missing ones.

    From merged summaries, `Groups`, powers (group, layer) above noise and neighbours, decay rates
    of eq. (2) (group, layer), values by layer of either estimator, and the flight's looks. Each has
    a jackknife standard error, from leaving out parts of the flight. A quantity that the flight is
    too short to estimate is set constant, has no error and is named in ``radiometry_missing``; then
    all layers count as visible, and no echoes lie below the last pick:

    - `noise_spread_db`, `surface_to_noise_spread_db`: standard deviation between blocks of 256 lines;
    - `common_spread_db`, `layer_spread_db`: of the power of buried layers in a block about each layer's mean over the
      flight, common to all and each layer's own; `decay_spread` of the logarithm of the decay rate,
      less its scatter within blocks;
    - `fading_spread_db`, `fading_length_lines`, `fading_exponent`, `fading_nugget_db2 (interface)`, surface then buried
      layers, see `fading`; `fading_speckle_db2` is the nugget expected from the looks;
    - `end_contrast_db`: rise over the snow above of layers below which none is picked, the lower quartile;
    - `line_gain_spread_db`, `texture_variance`, `texture_length_bins`, `texture_length_lines`: see `texture`;
    - `background_power (fall)`, mean power of unpicked snow, ``sum_k b_k exp(-depth / fall_k)``, and its
      `background_spread_db`; spacing and height of the echoes that rise out of it below the last
      pick, `further_spacing_bins` and `further_rise_db`.
    """
    frame_of = np.repeat(np.arange(len(summary)), [len(frame.power) for frame in summary])
    part_of = np.arange(len(summary)) * min(MOST_PARTS, len(summary)) // max(len(summary), 1)
    block_of, block_frame = _blocks(summary)
    own = _block_means(powers, block_of)
    background, profile = _background(groups, powers, by_layer)
    air = [_block_sums(stacked(summary, name), block_of) for name in ("air_sum", "air_count")]
    noise_db = DB * np.log(np.where(air[1] > 0, air[0] / np.maximum(air[1], 1), np.nan))
    power_db = DB * np.log(np.where(own > 0, own, np.nan))
    background_db = DB * np.log(
        np.maximum(_block_means(background[:, None], block_of)[:, 0], 1e-300)
    )
    decays = _block_decays(decay_rate, block_of)
    echoes = echoes_below(groups, block_of, n_looks)
    ends = end_contrasts(groups, frame_of)
    terms = stacked(summary, "texture_terms")
    products = fading_products(summary, powers, frame_of)
    speckle = DB**2 * polygamma(1, n_looks)

    def all_of(held):
        blocks = held[block_frame]
        ends_held = ends[1][held[ends[0]]]
        n_echoes, rise, n_rows = echoes[blocks].sum(axis=0)
        values = [
            _deviation(noise_db[blocks]),
            _deviation(power_db[blocks, 0] - noise_db[blocks]),
            *_two_spreads(power_db[blocks, 1:]),
            _decay_spread(decays[blocks]),
            _deviation(np.where(background_db[blocks] > -1000, background_db[blocks], np.nan)),
            n_rows / n_echoes if n_echoes else np.nan,
            rise / n_echoes if n_echoes else np.nan,
            np.quantile(ends_held, END_QUANTILE) if ends_held.size >= FEWEST else np.nan,
            *texture(terms[held[frame_of]]),
        ]
        depth, *profiles = (part[held[frame_of]] if part.ndim == 2 else part for part in profile)
        left, total, n = (part.sum(axis=0) for part in profiles)
        law = _background_law(depth, left / np.maximum(n, 1), total / np.maximum(n, 1), n)
        faded = [fading(products[held][:, kind].sum(axis=0), speckle) for kind in (0, 1)]
        return np.concatenate([values, np.ravel(faded), law])

    everything = np.ones(len(summary), dtype=bool)
    value, error = all_of(everything), np.full(len(NAMES) + 8 + len(LAW_FALLS), np.nan)
    parts = np.unique(part_of)
    if parts.size > 1:
        without = np.array([all_of(part_of != part) for part in parts])
        # NaN where the flight without one of its parts is too short.
        error = np.sqrt((parts.size - 1) * without.var(axis=0))
    missing = ~np.isfinite(value)
    value = np.where(missing, STAND_INS, value)
    error = np.where(missing | ~np.isfinite(error), 0.0, error)
    variables = {}
    for suffix, values in (("", value), ("_standard_error", error), ("_missing", missing)):
        faded = values[len(NAMES) : len(NAMES) + 8].reshape(2, 4)
        variables |= {name + suffix: ((), values[i]) for i, name in enumerate(NAMES)}
        kinds = ("fading_spread_db", "fading_length_lines", "fading_exponent", "fading_nugget_db2")
        variables |= {name + suffix: ("interface", faded[:, i]) for i, name in enumerate(kinds)}
        variables |= {"background_power" + suffix: ("fall", values[len(NAMES) + 8 :])}
    variables["fading_speckle_db2"] = ((), speckle)
    unknown = [name for name in list(variables) if name.endswith("_missing")]
    unknown = [name.removesuffix("_missing") for name in unknown if np.any(variables.pop(name)[1])]
    return variables, {"radiometry_missing": ", ".join(unknown)}


def _blocks(summary):
    """Number of the block of each group, over the flight, -1 beyond the last whole one; frame of each block."""
    numbers, frames = [], []
    for i, frame in enumerate(summary):
        n_groups = len(frame.power)
        n_blocks = max(n_groups * GROUP_LINES // BLOCK_LINES, min(n_groups, 1))
        number = ((np.arange(n_groups) + 0.5) * GROUP_LINES / BLOCK_LINES).astype(int)
        numbers.append(np.where(number < n_blocks, number + len(frames), -1))
        frames += [i] * n_blocks
    return np.concatenate(numbers), np.array(frames, dtype=int)


def _block_sums(values, block_of):
    """Sums over the groups of each block, (block, ...)."""
    total = np.zeros((block_of.max() + 1, *values.shape[1:]))
    np.add.at(total, block_of[block_of >= 0], values[block_of >= 0])
    return total


def _block_means(values, block_of):
    """Means over the groups of each block, (block, column); NaN where fewer than half have a value."""
    known = np.isfinite(values)
    n = _block_sums(known.astype(float), block_of)
    size = _block_sums(np.ones(len(values)), block_of)[:, None]
    return np.where(
        2 * n >= size, _block_sums(np.where(known, values, 0), block_of) / np.maximum(n, 1), np.nan
    )


def _deviation(values):
    held = values[np.isfinite(values)]
    return held.std(ddof=1) if held.size >= FEWEST else np.nan


def _two_spreads(power_db):
    """Standard deviations of dB (block, layer) about each layer's mean: common to a block's layers, and beyond that.

    The mean product of two layers of one block is the common variance. Subtracting means over n
    blocks removes 1 / n.
    """
    n = np.isfinite(power_db).sum(axis=0)
    usable = power_db[:, n >= FEWEST]
    if usable.shape[1] == 0:
        return np.nan, np.nan
    n = n[n >= FEWEST]
    known = np.isfinite(usable)
    deviation = np.where(known, usable - np.nanmean(usable, axis=0), 0) * np.sqrt(n / (n - 1))
    total = (deviation**2).sum() / known.sum()
    n_pairs = (known.sum(axis=1) ** 2).sum() - known.sum()
    if n_pairs < FEWEST:
        return 0.0, np.sqrt(total)
    common = ((deviation.sum(axis=1) ** 2).sum() - (deviation**2).sum()) / n_pairs
    common = np.clip(common, 0, total)
    return np.sqrt(common), np.sqrt(total - common)


def _block_decays(decay_rate, block_of):
    """Sums by block of the logarithm of decay rates about each layer's mean, of its square, and count, (block, 3)."""
    logarithm = np.log(np.where(decay_rate > 0, decay_rate, np.nan))
    known = np.isfinite(logarithm)
    n = known.sum(axis=0)
    mean = np.where(known, logarithm, 0).sum(axis=0) / np.maximum(n, 1)
    usable = known & (n >= 2)
    deviation = np.where(usable, logarithm - mean, 0)
    sums = np.column_stack([deviation.sum(axis=1), (deviation**2).sum(axis=1), usable.sum(axis=1)])
    return _block_sums(sums, block_of)


def _decay_spread(sums):
    """Standard deviation of block means, less the part due to scatter within blocks."""
    total, square, n = sums[sums[:, 2] >= 2].T
    if n.size < FEWEST:
        return np.nan
    mean = total / n
    within = (square - n * mean**2) / (n - 1)
    return np.sqrt(max(mean.var(ddof=1) - (within / n).mean(), 0.0))


def _modelled(groups, powers, by_layer):
    """Power of the picked layers alone, (group, row)."""
    variance, offset = by_layer["variance_bins2"], by_layer["offset_bins"]
    decay = by_layer["decay_rate"]
    known = np.isfinite(decay)
    # The deepest layer of `paper` has none.
    decay = np.where(known, decay, np.median(decay[known]) if known.any() else BACKGROUND_RISE)
    lead, height = waveform_peak(variance, decay)
    rows = np.arange(groups.power.shape[1]) + FIRST_ROW
    position, spread = (
        groups.position.mean(axis=2),
        groups.spread.mean(axis=2) + groups.position.var(axis=2),
    )
    total = np.zeros(groups.power.shape)
    for layer in range(len(decay)):
        held = np.flatnonzero(np.isfinite(powers[:, layer]) & np.isfinite(position[:, layer]))
        wide = (variance[layer] + spread[held, layer])[:, None]
        lag = rows - position[held, layer, None] - offset[layer] + lead[layer]
        one = (
            np.sqrt(variance[layer] / wide)
            * waveform_exact(lag, wide, decay[layer])
            / height[layer]
        )
        total[held] += powers[held, layer, None] * one
    return total


def _background(groups, powers, by_layer):
    """Mean unpicked power of each group; and rows, unpicked power, total power and weights by row, (group, row)."""
    rows = np.arange(groups.power.shape[1]) + FIRST_ROW
    left = groups.power - groups.noise_power - _modelled(groups, powers, by_layer)
    used = np.isfinite(left) & (rows >= BACKGROUND_FROM) & groups.present[:, :1]
    values = np.where(used, left, 0.0)
    shared = (
        rows
        <= np.median(np.nanmax(np.where(groups.present, groups.position.mean(axis=2), 0), axis=1))
        + 40
    )
    held = used & shared
    level = np.where(held, values, 0).sum(axis=1) / np.maximum(held.sum(axis=1), 1)
    total = np.where(used, groups.power, 0.0)
    return np.where(held.any(axis=1), level, np.nan), (rows, values, total, used.astype(float))


def _background_law(depth, level, total, count):
    """Coefficients of ``sum_k b_k exp(-depth / fall_k)``, none negative, (fall,).

    Least squares of the mean `level`, weighted by the speckle of the mean `total` power of `count`
    averaged lines.
    """
    held = (count >= FEWEST) & (total > 0)
    if held.sum() < len(LAW_FALLS):
        return np.full(len(LAW_FALLS), np.nan)
    scale = total[held] / np.sqrt(count[held])
    columns = np.exp(-depth[held, None] / LAW_FALLS) / scale[:, None]
    return nnls(columns, level[held] / scale)[0]
