"""What the powers of a scene tell a generator: how bright its layers and its snow are."""

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates

from snowsim.cgan.inputs import LEVEL_BINS, LEVEL_LINES, Levels
from snowsim.echogram import DB_BELOW_NOISE_FLOOR, to_db
from snowsim.labels import dress

# Pixels between which the level of snow, a mean over many more, is interpolated.
STEP_BINS, STEP_LINES = 4, 8


def expected_levels(scene, statistics):
    """`Levels` as a scene's physics has them, layers NaN where absent.

    Of the mean power ``noise + sum_j p_j w_j(x - x_j)`` in bin x, of all layers and backgrounds j
    with peak powers p_j: below its peak a waveform is ``exp(-a_j lag)``, above it ``exp(-lag^2 / (2
    d_j))``, a_j and d_j of eq. (1). Powers are the scene's own where it has echoes, else the
    flight's.
    """
    echoes = scene.echoes or dress(scene.layer_bins, statistics)
    lines = np.arange(scene.n_range_lines)
    at_layers = _expected_db(echoes, scene.layer_bins, lines)
    level = np.where(np.isfinite(scene.layer_bins), at_layers, np.nan)
    uppermost = np.isfinite(level).any(axis=1).argmax()
    scale = np.nanmean(level[uppermost])
    return Levels(level / scale, _level_of_snow(echoes, scene) / scale)


def _expected_db(echoes, at_bins, lines):
    """Mean power at some bins (row, line) of some range lines, in decibels above an image's 0."""
    shape = echoes.bins.shape
    powers = np.broadcast_to(echoes.power.reshape(shape[0], -1), shape)[:, lines]
    total = np.full(at_bins.shape, float(echoes.noise_power))
    waveforms = zip(
        echoes.bins[:, lines], powers, echoes.decay_rate, echoes.variance_bins2, strict=True
    )
    for row, power, decay, variance in waveforms:
        lag = at_bins - row
        rising = lag**2 / (2 * variance)
        reached = power * np.exp(-np.where(lag < 0, rising, decay * lag))
        total += np.where((power > 0) & np.isfinite(row), reached, 0)
    return to_db(total / echoes.noise_power) + DB_BELOW_NOISE_FLOOR


def _level_of_snow(echoes, scene):
    """Gaussian mean of the expected decibels, (range_bin, range_line)."""
    rows = np.arange(0, scene.n_range_bins + STEP_BINS - 1, STEP_BINS)
    lines = np.arange(0, scene.n_range_lines, STEP_LINES)
    at_bins = np.broadcast_to(rows[:, None], (rows.size, lines.size))
    spread = (LEVEL_BINS / STEP_BINS, LEVEL_LINES / STEP_LINES)
    coarse = gaussian_filter(_expected_db(echoes, at_bins, lines), spread, mode="nearest")
    every_bin = np.arange(scene.n_range_bins) / STEP_BINS
    every_line = np.arange(scene.n_range_lines) / STEP_LINES
    pixels = np.meshgrid(every_bin, every_line, indexing="ij")
    return map_coordinates(coarse, pixels, order=1, mode="nearest")
