"""Layers solved for jointly: powers and a shared waveform of eq. (1) on averaged range lines, noise known."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_solve

from snowsim.statistics.departures import clustered, departing, lasting_misfit
from snowsim.statistics.lines import background_columns, describe, prepare_line, rescale, solve_powers, waveform_columns
from snowsim.statistics.paper import nan_moments
from snowsim.statistics.summaries import FIRST_ROW

SHAPE_GROUPS = 60  # averaged lines per layer that fix its shape: 100 looks each leave decay rates known to some 1.5 %
# Residuals of so many standard deviations weigh half: Holland & Welsch (1977), Commun. Stat. A6, 813-827.
CAUCHY = 2.385
CLUSTER_GROUPS = 13  # averaged lines, about a block, within which what the model leaves out stays the same
FEWEST_CLUSTERS = 8  # of a flight; a shorter one has shorter ones
MAX_STEPS = 25
STEPS_TRIED = 4  # from each start, of which the better goes on
STEPS_ALONE = 6  # of layers all with shapes of their own, to see what no shape explains
MAX_ROUNDS = 4  # of letting layers depart from the shared shape
STEP_TOLERANCE = 5e-3  # of log decay, log variance and bins: a tenth of the smallest bound asked of them
LONGEST_STEP = np.array([0.5, 0.7, 2.0])
FIRST_VARIANCES = (0.7, 8.0)  # [bins^2] starts: of a waveform as narrow as the range response, and of a wide one
FIRST_DECAY = np.log([0.05, 0.5])  # range of starts, log of per bin
PRIOR_DEVIATION = np.array([1.0, 1.5, 4.0])  # log decay, log variance about their start; peak offset [bins]
RESIDUAL_TOLERANCE = 2e-4  # of itself: what then still moves, the data do not tell
LOWER = np.array([np.log(2e-3), np.log(0.25), -15.0])
UPPER = np.array([np.log(2.0), np.log(200.0), 15.0])


def deblend(groups, decay_rate):
    """Shapes and powers of all layers of a flight, solved for jointly.

    From `Groups` and the decay rates (group, layer) of eq. (2), NaN where there is none, whose medians are the start.
    Returns shapes (layer, 3), log decay rate, log variance and distance of the waveform's peak below the pick [bins];
    their standard errors; peak powers above noise, background and neighbours (group, layer), NaN where absent; the
    standard error of their mean, (layer,), from their scatter and the errors of the shapes; and which layers have a
    shape of their own, bool (layer,).

    Mean of a group: ``P(x) = noise + background + sum_l p_l w(x - x_l - c; d + v_l, alpha)``, w of eq. (1) of Yari et
    al. (2021), averaged over the parts of a group: the rows of a layer differ within a part by a variance v_l, which to
    second order widens the Gaussian, and nothing else. Powers and `background_columns` are free in every group and
    linear, so they are eliminated (variable projection, Kaufman 1975, BIT 15, 49-57). Decay rate, variance and offset
    are found by Gauss-Newton steps: one set for the surface, one shared by all buried layers, and a layer departs from
    it only where the Bayesian information criterion asks for it, see `departing`. Residuals weigh 1 / P^2, as speckle
    asks, and less where they are large (`CAUCHY`): echoes nobody picked are no part of the waveform. A broad prior
    (`PRIOR_DEVIATION`) holds what the data say nothing about. A layer that gaps hide between two others is kept as a
    nuisance at an interpolated row; what lies below the last pick was not annotated.

    Standard errors cover misfit: that of the model is taken to be the same within `CLUSTER_GROUPS` groups, and along
    the whole flight in a layer of its own (scores summed by either, the two variances added).
    """
    n_layers = groups.present.shape[1]
    prepared = {group: prepare_line(groups, group) for group in _spread_out(groups.present)}
    lines = [line for line in prepared.values() if line is not None]
    cluster = np.array([group for group, line in prepared.items() if line is not None])
    cluster //= int(np.clip(len(groups.power) // FEWEST_CLUSTERS, 1, CLUSTER_GROUPS))
    kind = np.minimum(np.arange(n_layers), 1)
    starts = _starts(decay_rate, kind)
    tried = (_solve(start, kind, lines, STEPS_TRIED) for start in starts)
    solution = _solve(min(tried, key=lambda found: found.loss).shape_of_kind, kind, lines)
    # What no common shape explains is estimated from shapes of their own.
    lasting = lasting_misfit(
        _solve(solution.shape_of_kind[kind], np.arange(n_layers), lines, STEPS_ALONE).shape_of_kind, lines
    )
    for _ in range(MAX_ROUNDS):
        own = departing(solution, cluster, kind, lasting)
        if not own.any():
            break
        start = np.concatenate([solution.shape_of_kind, solution.shape_of_kind[kind[own]]])
        kind = np.where(own, kind.max() + np.cumsum(own), kind)
        solution = _solve(start, kind, lines)
    shape, covariance = _with_covariance(solution, cluster, kind)
    shape_error = np.sqrt(np.diag(covariance)).reshape(n_layers, 3)
    powers = _powers(shape, groups)
    _, scatter, _ = nan_moments(powers)
    leverage = solution.leverage
    power_error = np.sqrt(scatter**2 + np.einsum("li,ij,lj->l", leverage, covariance, leverage))
    return shape, shape_error, powers, power_error, kind > 1


@dataclass(frozen=True)
class Solution:
    """Shapes by kind of layer (kind, 3) and what the last step knew: loss, matrix, gradients of lines, leverage."""

    shape_of_kind: np.ndarray
    loss: float
    hessian: np.ndarray  # (3 layer, 3 layer)
    scores: np.ndarray  # (line, 3 layer)
    leverage: np.ndarray  # (layer, 3 layer), mean change of the powers with the shapes


def _starts(decay_rate, kind):
    """First guesses (kind, 3): the decay rates of eq. (2), narrow and wide."""
    measured = np.isfinite(decay_rate) & (decay_rate > 0)
    start = np.tile([np.mean(FIRST_DECAY), 0.0, 0.0], (kind.max() + 1, 1))
    for k in range(len(start)):
        held = decay_rate[:, kind == k][measured[:, kind == k]]
        if held.size:
            start[k, 0] = np.clip(np.log(np.median(held)), *FIRST_DECAY)
    return [start + [0.0, np.log(variance), 0.0] for variance in FIRST_VARIANCES]


def _of_kind(kind):
    """Matrix from shapes by kind to shapes by layer, (3 layer, 3 kind)."""
    return np.kron(np.eye(kind.max() + 1)[kind], np.eye(3))


def _solve(start, kind, lines, n_steps=MAX_STEPS):
    """`Solution` from a start (kind, 3), by Gauss-Newton steps with residuals weighed anew at each."""
    spread = _of_kind(kind)
    shape, last = start, np.inf
    for line in lines:
        line.scale = line.smooth
    deviation = np.inf
    for _ in range(n_steps):
        hessian, gradient, scores, leverage, deviation, loss = _normal_equations(shape[kind], lines, deviation)
        information = deviation**2 / np.tile(PRIOR_DEVIATION, len(shape)) ** 2
        matrix = spread.T @ hessian @ spread
        matrix[np.diag_indices_from(matrix)] += information
        step = np.linalg.solve(matrix, spread.T @ gradient - information * (shape - start).ravel()).reshape(-1, 3)
        # A step cut as a whole keeps its direction; kinds apart, so that one bad layer does not hold up the others.
        step /= np.maximum(1, (np.abs(step) / LONGEST_STEP).max(axis=1, keepdims=True))
        moved = np.clip(shape + step, LOWER, UPPER) - shape
        shape = shape + moved
        if np.abs(moved).max() < STEP_TOLERANCE or abs(last - loss) < RESIDUAL_TOLERANCE * last:
            break
        last = loss
    return Solution(shape, loss, hessian, scores, leverage)


def _with_covariance(solution, cluster, kind):
    """Shapes by layer (layer, 3) and their covariance (3 layer, 3 layer), misfit covered."""
    spread = _of_kind(kind)
    by_line = solution.scores @ spread
    summed = clustered(by_line, cluster)
    by_layer = solution.scores.sum(axis=0).reshape(-1, 3)
    alone = np.zeros((kind.size, 3 * (kind.max() + 1)))
    for layer, k in enumerate(kind):
        alone[layer, 3 * k : 3 * k + 3] = by_layer[layer]
    # What lasts within clusters, as a mean over shapes: a few clusters alone would not tell it for each.
    lasting = np.mean((summed**2).sum(axis=0) / np.maximum((by_line**2).sum(axis=0), 1e-300))
    scatter = by_line.T @ by_line * max(lasting * len(summed) / max(len(summed) - 1, 1), 1) + alone.T @ alone
    matrix = spread.T @ solution.hessian @ spread
    matrix[np.diag_indices_from(matrix)] += 1e-12 * np.trace(matrix)
    inverse = np.linalg.inv(matrix)
    return solution.shape_of_kind[kind], spread @ inverse @ scatter @ inverse @ spread.T


def model_lines(shape, groups):
    """Averaged lines of the fitted model with its noise, (group, row), in the rows the fit used; NaN elsewhere."""
    lines = np.full(groups.power.shape, np.nan)
    for group, line, columns in _columns(shape, groups):
        lines[group, line.rows - FIRST_ROW] = solve_powers(columns, line)[0] @ columns + groups.noise_power
    return lines


def _columns(shape, groups):
    """Yield the number of each group that can be fitted, its `Line` and the linear model of that."""
    described = describe(shape)
    for group in range(len(groups.power)):
        line = prepare_line(groups, group)
        if line is not None:
            yield group, line, np.concatenate([waveform_columns(described, line), background_columns(line)])


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


def _normal_equations(shape, lines, deviation):
    """What a Gauss-Newton step needs: matrix and gradient of all shapes, gradient of each line.

    Then the mean change of the powers with the shapes, (layer, 3 layer), and of the residuals the standard deviation,
    from their median, and the mean loss. Residuals weigh as `deviation` of the step before says.
    """
    n_layers = len(shape)
    hessian = np.zeros((3 * n_layers, 3 * n_layers))
    scores = np.zeros((len(lines), 3 * n_layers))
    leverage, n_lines = np.zeros((n_layers, 3 * n_layers)), np.zeros(n_layers)
    described = describe(shape)
    residuals = []
    for i, line in enumerate(lines):
        columns = waveform_columns(described, line, with_slopes=True)
        linear = np.concatenate([columns[0], background_columns(line)])
        n = line.layers.size
        powers, _ = solve_powers(linear, line)
        relative = (line.signal - powers @ linear) / line.scale
        # Less weight to large residuals, then once more.
        weighed = replace(line, scale=line.scale * np.sqrt(1 + (relative / (CAUCHY * deviation)) ** 2))
        powers, factor = solve_powers(linear, weighed)
        model = powers @ linear
        residuals.append((line.signal - model) / line.scale)
        # Layers between picks help to explain the line; where they are guessed, they say nothing on their shape.
        slopes = (columns[1:] * powers[:n, None] / weighed.scale)[:, line.picked]
        slopes = slopes.transpose(1, 0, 2).reshape(-1, line.rows.size)
        mixed = linear / weighed.scale @ slopes.T
        at = (3 * line.layers[line.picked, None] + np.arange(3)).ravel()
        by_shape = cho_solve(factor, mixed)
        hessian[np.ix_(at, at)] += slopes @ slopes.T - mixed.T @ by_shape
        leverage[np.ix_(line.layers[line.picked], at)] -= by_shape[:n][line.picked]
        n_lines[line.layers[line.picked]] += 1
        scores[i, at] = slopes @ ((line.signal - model) / weighed.scale)
        rescale(line, model)
    leverage /= np.maximum(n_lines, 1)[:, None]
    residuals = np.concatenate(residuals)
    deviation = max(np.median(np.abs(residuals)) / 0.6745, 1e-6)
    loss = np.log1p((residuals / (CAUCHY * deviation)) ** 2).mean() * deviation**2
    return hessian, scores.sum(axis=0), scores, leverage, deviation, loss


def _powers(shape, groups):
    """Peak powers of all groups, (group, layer), NaN where a layer was not picked."""
    powers = np.full(groups.present.shape, np.nan)
    for group, line, columns in _columns(shape, groups):
        first, _ = solve_powers(columns, line)
        rescale(line, first @ columns)
        powers[group, line.layers] = solve_powers(columns, line)[0][: line.layers.size]
    return np.where(groups.present, powers, np.nan)
