"""What the powers of a scene tell a generator: how bright its layers and its snow are."""

import numpy as np
from scipy.ndimage import gaussian_filter

from snowsim.cgan.fades import draw_fades
from snowsim.cgan.inputs import LEVEL_BINS, LEVEL_LINES, Levels
from snowsim.echogram import DB_BELOW_NOISE_FLOOR, to_db
from snowsim.labels.dress import dress

# Pixels between which the level of snow, a mean over many more, is interpolated.
STEP_BINS, STEP_LINES = 4, 8


def expected_levels(scene, statistics, *, fade_spread=0.0, rng=None):
    """`Levels` as a scene's physics has them, layers NaN where absent.

    Of the mean power ``noise + sum_j p_j w_j(x - x_j)`` in bin x, of all layers and backgrounds j
    with peak powers p_j: below its peak a waveform is ``exp(-a_j lag)``, above it ``exp(-lag^2 / (2
    d_j))``, a_j and d_j of eq. (1). Powers are the scene's own where it has echoes, else the
    flight's. An image spans the decibels from noise to its maximum: where the uppermost layer
    stands higher above the noise than the flight's, a decibel has fewer grey levels. Fades are
    those of `draw_fades`, drawn from `rng`.
    """
    of_flight = dress(scene.layer_bins, statistics)
    echoes = scene.echoes or of_flight
    lines = np.arange(scene.n_range_lines)
    at_layers = _expected_db(echoes, scene.layer_bins, lines)
    level = np.where(np.isfinite(scene.layer_bins), at_layers, np.nan)
    uppermost = np.isfinite(level).any(axis=1).argmax()
    scale = np.nanmean(level[uppermost])
    usual = _expected_db(of_flight, scene.layer_bins[[uppermost]], lines)
    contrast = np.nanmean(usual) / scale
    of_snow = _level_of_snow(echoes, scene) / scale
    fades = 0.0
    if fade_spread:
        surface = scene.layer_bins[uppermost]
        fades = draw_fades(surface, scene.n_range_bins, fade_spread, rng=rng)
    return Levels(level / scale, of_snow, contrast, fades)


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
    of_every_line = _between(coarse.T, STEP_LINES, scene.n_range_lines).T
    return _between(of_every_line, STEP_BINS, scene.n_range_bins)


def _between(values, step, n):
    """Rows straight between those of `values`, one in `step` of `n`; beyond the last, that."""
    at = np.minimum(np.arange(n) / step, len(values) - 1)
    before = at.astype(int)
    after = np.minimum(before + 1, len(values) - 1)
    share = (at - before)[:, None]
    return (1 - share) * values[before] + share * values[after]
