"""Layers solved for jointly: powers and a shared waveform of eq. (1) on averaged range lines, noise known."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dpotrs

from snowsim.statistics.departures import clustered, departing, lasting_misfit
from snowsim.statistics.lines import describe, prepare_line, rescale, solve_powers, waveform_columns
from snowsim.statistics.paper import nan_moments
from snowsim.statistics.summaries import FIRST_ROW

SHAPE_GROUPS = (
    60  # averaged lines per layer to fit its shape: 100 looks each give decay rates to about 1.5 %
)
# Residuals so many standard deviations above the model have half weight, as of Cauchy's law; those
# below it keep it.
CAUCHY = 1.0
CLUSTER_GROUPS = 13  # averaged lines, about a block, within which misfit is taken as constant
FEWEST_CLUSTERS = 8  # of a flight; a short flight has shorter clusters
MAX_STEPS = 25
STEPS_TRIED = 4  # from each start; the better one goes on
STEPS_ALONE = 6  # with a shape for every layer, to find the misfit that no shape explains
MAX_ROUNDS = 4  # of letting layers depart from the shared shape
STEP_TOLERANCE = (
    5e-3  # of log decay, log variance and bins: a tenth of the smallest bound asked of them
)
LONGEST_STEP = np.array([0.5, 0.7, 2.0])
FIRST_VARIANCES = (
    0.7,
    8.0,
)  # [bins^2] starts: of a waveform as narrow as the range response, and of a wide one
FIRST_DECAY = np.log([0.05, 0.5])  # range of starts, log of per bin
PRIOR_DEVIATION = np.array(
    [1.0, 1.5, 4.0]
)  # log decay, log variance about their start; peak offset [bins]
RESIDUAL_TOLERANCE = (
    2e-4  # relative change of the loss: what still moves then, the data do not constrain
)
LOWER = np.array([np.log(2e-3), np.log(0.25), -15.0])
UPPER = np.array([np.log(2.0), np.log(200.0), 15.0])


def deblend(groups, decay_rate):
    """Shapes and powers of all layers of a flight, solved for jointly.

    From `Groups` and the decay rates (group, layer) of eq. (2), NaN where there is none; their
    medians are the start. Returns shapes (layer, 3), log decay rate, log variance and distance of
    the waveform's peak below the pick [bins]; their standard errors; peak powers above noise,
    background and neighbours (group, layer), NaN where absent; the standard error of their mean,
    (layer,), from their scatter and the errors of the shapes; which layers have a shape of their
    own, bool (layer,); and the fitted lines with their noise, (group, row), NaN where no row was
    used.

    Mean of a group: ``P(x) = noise + background + sum_l p_l w(x - x_l - c; d + v_l, alpha)``, w of
    eq. (1) of Yari et al. (2021), averaged over the parts of a group: within a part, a layer's rows
    have a variance v_l, which to second order only widens the Gaussian. Powers and
    `Line.background` are free in every group and linear, so they are eliminated (variable
    projection, Kaufman 1975, BIT 15, 49-57). Decay rate, variance and offset are found by
    Gauss-Newton steps: one set for the surface, one shared by all buried layers; a layer departs
    from it only if the Bayesian information criterion favours it, see `departing`. Residuals are
    weighted by 1 / P^2 because of speckle, and positive ones less (`CAUCHY`), because unpicked
    echoes only add to the waveforms. A broad prior (`PRIOR_DEVIATION`) holds what the data do not
    constrain. An unpicked layer between two picked ones is kept as a nuisance at an interpolated
    row; below the last pick nothing is annotated.

    Standard errors include misfit, which is taken as constant within `CLUSTER_GROUPS` groups, and
    for each layer along the whole flight (scores are summed by either, and the two variances
    added).
    """
    n_layers = groups.present.shape[1]
    prepared = {group: prepare_line(groups, group) for group in _spread_out(groups.present)}
    lines = [line for line in prepared.values() if line is not None]
    cluster = np.array([group for group, line in prepared.items() if line is not None])
    cluster //= int(np.clip(len(groups.power) // FEWEST_CLUSTERS, 1, CLUSTER_GROUPS))
    kind = np.minimum(np.arange(n_layers), 1)
    tried = (_solve(start, kind, lines, STEPS_TRIED) for start in _starts(decay_rate, kind))
    solution = _solve(min(tried, key=lambda found: found.loss).shape_of_kind, kind, lines)
    # Misfit that no shape explains is estimated with a shape for every layer.
    lasting = lasting_misfit(
        _solve(solution.shape_of_kind[kind], np.arange(n_layers), lines, STEPS_ALONE).shape_of_kind,
        lines,
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
    powers, modelled = _powers(shape, groups)
    _, scatter, _ = nan_moments(powers)
    leverage = solution.leverage
    power_error = np.sqrt(scatter**2 + np.einsum("li,ij,lj->l", leverage, covariance, leverage))
    return shape, shape_error, powers, power_error, kind > 1, modelled


@dataclass(frozen=True)
class Solution:
    """Shapes by kind of layer (kind, 3), and of the last step: loss, matrix, gradients of lines, leverage."""

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
    """`Solution` from a start (kind, 3), by Gauss-Newton steps that each reweight the residuals."""
    spread = _of_kind(kind)
    shape, last, deviation = start, np.inf, np.inf
    for line in lines:
        line.scale = line.smooth
    for _ in range(n_steps):
        hessian, gradient, scores, leverage, deviation, loss = _normal_equations(
            shape[kind], lines, deviation
        )
        information = deviation**2 / np.tile(PRIOR_DEVIATION, len(shape)) ** 2
        matrix = spread.T @ hessian @ spread
        matrix[np.diag_indices_from(matrix)] += information
        step = np.linalg.solve(
            matrix, spread.T @ gradient - information * (shape - start).ravel()
        ).reshape(-1, 3)
        # Scaled as a whole, a step keeps its direction; by kind, so that one bad layer does not
        # slow the others.
        step /= np.maximum(1, (np.abs(step) / LONGEST_STEP).max(axis=1, keepdims=True))
        moved = np.clip(shape + step, LOWER, UPPER) - shape
        shape = shape + moved
        if np.abs(moved).max() < STEP_TOLERANCE or abs(last - loss) < RESIDUAL_TOLERANCE * last:
            break
        last = loss
    return Solution(shape, loss, hessian, scores, leverage)


def _with_covariance(solution, cluster, kind):
    """Shapes by layer (layer, 3) and their covariance (3 layer, 3 layer), misfit included."""
    spread = _of_kind(kind)
    by_line = solution.scores @ spread
    summed = clustered(by_line, cluster)
    by_layer = solution.scores.sum(axis=0).reshape(-1, 3)
    alone = np.zeros((kind.size, 3 * (kind.max() + 1)))
    for layer, k in enumerate(kind):
        alone[layer, 3 * k : 3 * k + 3] = by_layer[layer]
    # Correlation within clusters, as a mean over shapes: there are too few clusters to estimate it
    # for each.
    lasting = np.mean((summed**2).sum(axis=0) / np.maximum((by_line**2).sum(axis=0), 1e-300))
    scatter = (
        by_line.T @ by_line * max(lasting * len(summed) / max(len(summed) - 1, 1), 1)
        + alone.T @ alone
    )
    matrix = spread.T @ solution.hessian @ spread
    matrix[np.diag_indices_from(matrix)] += 1e-12 * np.trace(matrix)
    inverse = np.linalg.inv(matrix)
    return solution.shape_of_kind[kind], spread @ inverse @ scatter @ inverse @ spread.T


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

    Then the mean change of the powers with the shapes, (layer, 3 layer), the standard deviation of
    the residuals, from their median, and the mean loss. The residuals' weights follow from the
    `deviation` of the step before.
    """
    n_layers = len(shape)
    hessian = np.zeros((3 * n_layers, 3 * n_layers))
    scores = np.zeros((len(lines), 3 * n_layers))
    leverage, n_lines = np.zeros((n_layers, 3 * n_layers)), np.zeros(n_layers)
    described, residuals = describe(shape), []
    for i, line in enumerate(lines):
        columns = waveform_columns(described, line, with_slopes=True)
        linear = np.concatenate([columns[0], line.background])
        n = line.layers.size
        powers, _ = solve_powers(linear, line)
        relative = (line.signal - powers @ linear) / line.scale
        # Solved again with less weight on residuals above the model.
        above = np.maximum(relative, 0) / (CAUCHY * deviation)
        scale = line.scale * np.sqrt(1 + above**2)
        powers, factor = solve_powers(linear, line, scale)
        model = powers @ linear
        residuals.append((line.signal - model) / line.scale)
        # Unpicked layers between picks help to explain the line, but at guessed rows do not
        # constrain their shape.
        slopes = (columns[1:] * powers[:n, None] / scale)[:, line.picked]
        slopes = slopes.transpose(1, 0, 2).reshape(-1, line.rows.size)
        mixed = linear / scale @ slopes.T
        layers = line.layers[line.picked]
        at = (3 * layers[:, None] + np.arange(3)).ravel()
        by_shape = dpotrs(factor, mixed)[0]
        hessian[at[:, None], at] += slopes @ slopes.T - mixed.T @ by_shape
        leverage[layers[:, None], at] -= by_shape[:n][line.picked]
        n_lines[layers] += 1
        scores[i, at] = slopes @ ((line.signal - model) / scale)
        rescale(line, model)
    leverage /= np.maximum(n_lines, 1)[:, None]
    residuals = np.concatenate(residuals)
    deviation = max(np.median(np.abs(residuals)) / 0.6745, 1e-6)
    above, below = (np.maximum(sign * residuals, 0) / (CAUCHY * deviation) for sign in (1, -1))
    loss = (np.log1p(above**2) + below**2).mean() * deviation**2
    return hessian, scores.sum(axis=0), scores, leverage, deviation, loss


def _powers(shape, groups):
    """Peak powers of all groups, (group, layer), NaN where a layer was not picked; their lines as first fitted.

    The latter are (group, row), with the noise, in the rows the fit used; NaN elsewhere.
    """
    powers, modelled = np.full(groups.present.shape, np.nan), np.full(groups.power.shape, np.nan)
    described = describe(shape)
    for group in range(len(groups.power)):
        line = prepare_line(groups, group)
        if line is None:
            continue
        columns = np.concatenate([waveform_columns(described, line), line.background])
        model = solve_powers(columns, line)[0] @ columns
        modelled[group, line.rows - FIRST_ROW] = model + groups.noise_power
        rescale(line, model)
        powers[group, line.layers] = solve_powers(columns, line)[0][: line.layers.size]
    return np.where(groups.present, powers, np.nan), modelled
