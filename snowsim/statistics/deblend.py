"""Layers solved for jointly: powers, decay rates and variances of eq. (1) on averaged range lines, noise known."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.ndimage import uniform_filter1d

from snowsim.phy.waveform import waveform_exact, waveform_peak
from snowsim.statistics.paper import OPEN_END_BINS, nan_moments
from snowsim.statistics.summaries import FIRST_ROW

RISE_DEVIATIONS = 7.0  # a waveform is cut where it is 1e-10 of its peak above
FALL_NEPERS = 14.0  # and 1e-6 of it below
SHAPE_GROUPS = 150  # averaged lines per layer that fix its shape: 100 looks each leave decay rates known to some 1 %
MAX_STEPS = 25
STEP_TOLERANCE = 5e-3  # of log decay, log variance and bins: a tenth of the smallest bound asked of them
LONGEST_STEP = np.array([0.5, 0.7, 2.0])
FIRST_GUESS = np.array([np.log(0.07), np.log(8.0)])
FIRST_DECAY = np.log([0.02, 0.5])  # range of starts, log of per bin
PRIOR_DEVIATION = np.array([1.0, 1.5, 4.0])  # log decay, log variance about the flight's median; peak offset [bins]
RESIDUAL_TOLERANCE = 2e-4  # of itself: what then still moves, the data do not tell
LOWER = np.array([np.log(2e-3), np.log(0.25), -15.0])
UPPER = np.array([np.log(2.0), np.log(200.0), 15.0])


@dataclass(frozen=True)
class Groups:
    """Averaged range lines of a flight with the layers in them."""

    power: np.ndarray  # (group, row), rows from `FIRST_ROW` below the surface; NaN outside the record
    # (group, layer, part), NaN where absent: equal parts of a layer's lines in order of depth
    position: np.ndarray  # mean row
    spread: np.ndarray  # variance of the rows [bins^2]
    present: np.ndarray  # (group, layer), bool
    noise_power: float


@dataclass
class Line:
    """One averaged line, ready to fit."""

    rows: np.ndarray  # those used, (row,)
    signal: np.ndarray  # power above noise, (row,)
    noise_power: float
    smooth: np.ndarray  # smoothed power, (row,)
    layers: np.ndarray  # numbers of its layers, (layer,)
    position: np.ndarray  # (layer, part)
    spread: np.ndarray  # (layer, part)
    picked: np.ndarray  # (layer,), False for layers that gaps hide between others
    scale: np.ndarray  # residuals weigh 1 / scale^2, (row,)


def prepare_line(groups, group):
    """The group as `Line`, down to half a slab below its last pick; None without a picked layer to fit."""
    rows = np.arange(groups.power.shape[1]) + FIRST_ROW
    picked = np.flatnonzero(groups.present[group])
    if picked.size == 0:
        return None
    layers = np.arange(picked[0], picked[-1] + 1)
    position, spread = (_between(layers, picked, part[group, picked]) for part in (groups.position, groups.spread))
    last = position[-1].mean()
    below = (last - position[-2].mean()) / 2 if layers.size > 1 else OPEN_END_BINS
    with np.errstate(invalid="ignore"):
        used = (rows <= last + below) & np.isfinite(groups.power[group])
    signal = groups.power[group, used].astype(float) - groups.noise_power
    if signal.size <= 2 * layers.size:
        return None
    smooth = np.maximum(uniform_filter1d(signal, 9, mode="nearest") + groups.noise_power, groups.noise_power)
    return Line(
        rows[used], signal, groups.noise_power, smooth, layers, position, spread, np.isin(layers, picked), smooth
    )


def _between(layers, picked, values):
    """Values (layer, part) of picked layers, interpolated linearly for those between."""
    return np.column_stack([np.interp(layers, picked, part) for part in values.T])


def waveform_columns(described, line, *, with_slopes=False):
    """Waveforms of unit peak of a line, (layer, row); with slopes by the three columns of `shape`, (4, layer, row).

    The slopes follow from eq. (1): ``dw/dx = g - a w`` and ``dw/da = -((x - a d) w + d g)`` for its Gaussian g, and
    ``dw/dd = w / 2d + w'' / 2``, as the Gaussian obeys the heat equation. At the peak x0, where ``g = a w``, they give
    its height, ``d log w0 / d log a = -a x0`` and ``d log w0 / d log d = (1 - a x0) / 2``, and, by w' = 0, its
    movement.
    """
    columns = np.zeros((4 if with_slopes else 1, line.layers.size, line.rows.size))
    for position, spread in zip(line.position.T, line.spread.T, strict=True):
        _add_columns(columns, described, line, position, spread)
    columns /= line.position.shape[1]
    return columns if with_slopes else columns[0]


def _add_columns(columns, described, line, position, spread):
    """Add the columns of one part of the lines to (1 or 4, layer, row)."""
    lag = line.rows - (position + (described.offset - described.peak)[line.layers])[:, None]
    wide = described.variance[line.layers] + spread
    reached = (lag > -RISE_DEVIATIONS * np.sqrt(wide)[:, None]) & (
        lag * described.decay[line.layers, None] < FALL_NEPERS
    )
    of, lag = np.nonzero(reached)[0], lag[reached]
    layer, wide = line.layers[of], wide[of]
    decay, variance, peak = described.decay[layer], described.variance[layer], described.peak[layer]
    raw = waveform_exact(lag, wide, decay)
    unit = np.sqrt(variance / wide) / described.height[layer]
    columns[0, reached] += unit * raw
    if len(columns) == 1:
        return
    gaussian = np.exp(-(lag**2) / (2 * wide))
    along = gaussian - decay * raw
    by_decay = -((lag - decay * wide) * raw + wide * gaussian)
    by_variance = raw / (2 * wide) - (lag / wide * gaussian + decay * along) / 2
    peak_by_decay = -variance * (1 - decay * peak) / peak
    peak_by_variance = (peak**2 - variance + decay * variance * peak) / (2 * peak)
    columns[1, reached] += unit * (decay * by_decay + along * peak_by_decay + raw * (decay * peak))
    height_by_variance = (decay * peak - variance / wide) / 2
    columns[2, reached] += unit * (variance * by_variance + along * peak_by_variance + raw * height_by_variance)
    columns[3, reached] -= unit * along


@dataclass(frozen=True)
class Described:
    """Each layer's decay rate, variance, peak below the pick and below the Gaussian, and height of the peak."""

    decay: np.ndarray
    variance: np.ndarray
    offset: np.ndarray
    peak: np.ndarray
    height: np.ndarray


def describe(shape):
    """`Described` of the layers of `shape`."""
    decay, variance = np.exp(shape[:, 0]), np.exp(shape[:, 1])
    return Described(decay, variance, shape[:, 2], *waveform_peak(variance, decay))


def solve_powers(columns, line):
    """Least-squares powers of a line, (layer,), and the factor of their normal matrix."""
    weighted = columns / line.scale
    normal = weighted @ weighted.T
    # Two layers under one another cannot be told apart: 1e-9 of the diagonal keeps the factor, far below the noise.
    normal[np.diag_indices_from(normal)] *= 1 + 1e-9
    normal[np.diag_indices_from(normal)] += 1e-300
    factor = cho_factor(normal)
    return cho_solve(factor, weighted @ (line.signal / line.scale)), factor


def rescale(line, model):
    """Weight scale of the next step: the mean power expected, but never below the smoothed one."""
    line.scale = np.maximum(model + line.noise_power, line.smooth)


def deblend(groups, decay_rate):
    """Shapes and powers of all layers of a flight, solved for jointly.

    From `Groups` and the decay rates (group, layer) of eq. (2), NaN where there is none, whose medians are the start:
    one start for all layers can end where a layer's neighbour takes over its echo. Returns shapes (layer, 3), log decay
    rate, log variance and distance of the waveform's peak below the pick [bins]; their standard errors, from the
    scatter of the groups (sandwich); peak powers above noise and neighbours (group, layer), NaN where absent; and the
    standard error of their mean, (layer,), from their scatter and the errors of the shapes.

    Mean of a group: ``P(x) = noise + sum_l p_l w(x - x_l - c_l; d_l + v_l, alpha_l)``, w of eq. (1) of Yari et al.
    (2021), averaged over the parts of a group: the rows of a layer differ within a part by a variance v_l, which to
    second order widens the Gaussian, and nothing else. Powers are free in every group and linear, so they are
    eliminated (variable projection, Kaufman 1975, BIT 15, 49-57); decay rate, variance and offset of a layer are shared
    by the flight, found by Gauss-Newton steps. Residuals weigh 1 / P^2, as speckle asks. A broad prior
    (`PRIOR_DEVIATION`) ties layers the data say nothing about to the median of the others. A layer that gaps hide
    between two others is kept as a nuisance at an interpolated row; what lies below the last pick was not annotated.
    """
    n_layers = groups.present.shape[1]
    lines = [line for group in _spread_out(groups.present) if (line := prepare_line(groups, group)) is not None]
    shape = np.tile([*FIRST_GUESS, 0.0], (n_layers, 1))
    measured = np.isfinite(decay_rate) & (decay_rate > 0)
    for layer in np.flatnonzero(measured.any(axis=0)):
        shape[layer, 0] = np.clip(np.log(np.median(decay_rate[measured[:, layer], layer])), *FIRST_DECAY)
    last = np.inf
    for _ in range(MAX_STEPS):
        hessian, gradient, scores, residual_variance, leverage = _normal_equations(shape, lines, n_layers)
        information = residual_variance / np.tile(PRIOR_DEVIATION, n_layers) ** 2
        centre = np.column_stack([np.tile(np.median(shape[:, :2], axis=0), (n_layers, 1)), np.zeros(n_layers)])
        hessian[np.diag_indices_from(hessian)] += information
        step = np.linalg.solve(hessian, gradient - information * (shape - centre).ravel()).reshape(n_layers, 3)
        # A step cut as a whole keeps its direction; layers apart, so that one bad layer does not hold up the others.
        step /= np.maximum(1, (np.abs(step) / LONGEST_STEP).max(axis=1, keepdims=True))
        moved = np.clip(shape + step, LOWER, UPPER) - shape
        shape = shape + moved
        if np.abs(moved).max() < STEP_TOLERANCE or abs(last - residual_variance) < RESIDUAL_TOLERANCE * last:
            break
        last = residual_variance
    covariance = np.linalg.solve(hessian, np.linalg.solve(hessian, scores.T @ scores).T)
    shape_error = np.sqrt(np.maximum(np.diag(covariance), 0)).reshape(n_layers, 3)
    powers = _powers(shape, groups)
    _, scatter, _ = nan_moments(powers)
    return shape, shape_error, powers, np.sqrt(scatter**2 + np.einsum("li,ij,lj->l", leverage, covariance, leverage))


def model_lines(shape, groups):
    """Averaged lines of the fitted model with its noise, (group, row), in the rows the fit used; NaN elsewhere."""
    lines = np.full(groups.power.shape, np.nan)
    described = describe(shape)
    for group in range(len(lines)):
        line = prepare_line(groups, group)
        if line is not None:
            columns = waveform_columns(described, line)
            lines[group, line.rows - FIRST_ROW] = solve_powers(columns, line)[0] @ columns + groups.noise_power
    return lines


def _spread_out(present):
    """Groups to fit shapes to, sorted: for each layer, deepest first, evenly spaced ones until it has enough."""
    chosen = np.zeros(len(present), dtype=bool)
    for layer in reversed(range(present.shape[1])):
        missing = SHAPE_GROUPS - int((chosen & present[:, layer]).sum())
        spare = np.flatnonzero(present[:, layer] & ~chosen)
        if missing > 0 and spare.size:
            take = np.linspace(0, spare.size - 1, min(missing, spare.size)).round().astype(int)
            chosen[spare[take]] = True
    return np.flatnonzero(chosen)


def _normal_equations(shape, lines, n_layers):
    """What a Gauss-Newton step needs: matrix and gradient of all shapes, gradient of each line, variance of residuals.

    Last comes the mean change of the powers with the shapes, (layer, 3 layer).
    """
    hessian = np.zeros((3 * n_layers, 3 * n_layers))
    scores = np.zeros((len(lines), 3 * n_layers))
    leverage, n_lines = np.zeros((n_layers, 3 * n_layers)), np.zeros(n_layers)
    squares, freedom = 0.0, 0
    described = describe(shape)
    for i, line in enumerate(lines):
        columns = waveform_columns(described, line, with_slopes=True)
        powers, factor = solve_powers(columns[0], line)
        model = powers @ columns[0]
        residual = (line.signal - model) / line.scale
        # Layers between picks help to explain the line; where they are guessed, they say nothing on their shape.
        slopes = (columns[1:] * powers[:, None] / line.scale)[:, line.picked]
        slopes = slopes.transpose(1, 0, 2).reshape(-1, line.rows.size)
        weighted = columns[0] / line.scale
        mixed = weighted @ slopes.T
        at = (3 * line.layers[line.picked, None] + np.arange(3)).ravel()
        by_shape = cho_solve(factor, mixed)
        hessian[np.ix_(at, at)] += slopes @ slopes.T - mixed.T @ by_shape
        leverage[np.ix_(line.layers[line.picked], at)] -= by_shape[line.picked]
        n_lines[line.layers[line.picked]] += 1
        scores[i, at] = slopes @ residual
        squares += residual @ residual
        freedom += line.rows.size - line.layers.size
        rescale(line, model)
    leverage /= np.maximum(n_lines, 1)[:, None]
    return hessian, scores.sum(axis=0), scores, squares / max(freedom, 1), leverage


def _powers(shape, groups):
    """Peak powers of all groups, (group, layer), NaN where a layer was not picked."""
    powers = np.full(groups.present.shape, np.nan)
    described = describe(shape)
    for group in range(len(powers)):
        line = prepare_line(groups, group)
        if line is None:
            continue
        columns = waveform_columns(described, line)
        first, _ = solve_powers(columns, line)
        rescale(line, first @ columns)
        powers[group, line.layers] = solve_powers(columns, line)[0]
    return np.where(groups.present, powers, np.nan)
