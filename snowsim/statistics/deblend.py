"""Layers solved for jointly: powers and a shared waveform of eq. (1) on averaged range lines."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dpotrs

from snowsim.progress import shown
from snowsim.statistics.departures import clustered, departing, lasting_misfit
from snowsim.statistics.lines import describe, prepare_line, rescale, solve_powers, waveform_columns
from snowsim.statistics.moments import nan_moments
from snowsim.statistics.summaries import FIRST_ROW

# Averaged lines per layer to fit its shape: 100 looks each give decay rates to about 1.5 %.
SHAPE_GROUPS = 60
# Residuals so many standard deviations above the model have half weight, as of Cauchy's law; those
# below it keep it.
CAUCHY = 1.0
NORMAL_MEDIAN = 0.6745  # of the magnitude of a standard normal variable
LEAST_DEVIATION = 1e-6  # of relative residuals, where lines are free of speckle
CLUSTER_GROUPS = 13  # averaged lines, about a block, within which misfit is taken as constant
FEWEST_CLUSTERS = 8  # of a flight; a short flight has shorter clusters
MAX_STEPS = 25
STEPS_TRIED = 4  # from each start; the better one goes on
STEPS_ALONE = 6  # with a shape for every layer, to find the misfit that no shape explains
MAX_ROUNDS = 4  # of letting layers depart from the shared shape
# Of log decay, log variance and bins: a tenth of the smallest bound asked of them.
STEP_TOLERANCE = 5e-3
LONGEST_STEP = np.array([0.5, 0.7, 2.0])
# [bins^2] starts: of a waveform as narrow as the range response, and of a wide one.
FIRST_VARIANCES = (0.7, 8.0)
FIRST_DECAY = np.log([0.05, 0.5])  # range of starts, log of per bin
# Of log decay and log variance about their start, and of the peak's offset [bins].
PRIOR_DEVIATION = np.array([1.0, 1.5, 4.0])
# Relative change of the loss: what still moves then, the data do not constrain.
RESIDUAL_TOLERANCE = 2e-4
LOWER = np.array([np.log(2e-3), np.log(0.25), -15.0])
UPPER = np.array([np.log(2.0), np.log(200.0), 15.0])
RIDGE = 1e-12  # of the matrix's trace, without which it may be singular


@dataclass(frozen=True)
class Deblended:
    """Joint solution for all layers of a flight.

    The three numbers of a shape are log decay rate, log variance and distance of the waveform's
    peak below the pick [bins].
    """

    shape: np.ndarray  # (layer, 3)
    shape_error: np.ndarray  # standard errors, (layer, 3)
    # Above noise, background and neighbours, (group, layer), NaN where absent:
    powers: np.ndarray
    # Standard error of their mean, from their scatter and the errors of the shapes, (layer,):
    power_error: np.ndarray
    own_shape: np.ndarray  # which layers have a shape of their own, bool (layer,)
    # The fitted lines with their noise, (group, row), NaN where no row was used:
    modelled: np.ndarray


def deblend(groups, decay_rate):
    """Shapes and powers of all layers of a flight, solved for jointly, as `Deblended`.

    From `Groups` and the decay rates (group, layer) of eq. (2), NaN where there is none; their
    medians are the start.

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
    n_groups, n_layers = groups.present.shape
    prepared = {group: prepare_line(groups, group) for group in _spread_out(groups.present)}
    prepared = {group: line for group, line in prepared.items() if line is not None}
    lines = list(prepared.values())
    cluster_groups = np.clip(n_groups // FEWEST_CLUSTERS, 1, CLUSTER_GROUPS)
    cluster = np.array(list(prepared)) // cluster_groups
    # The surface is of kind 0, buried layers are of kind 1 until one departs.
    kind = np.minimum(np.arange(n_layers), 1)
    tried = [_solve(start, kind, lines, STEPS_TRIED) for start in _starts(decay_rate, kind)]
    better = min(tried, key=lambda solution: solution.equations.loss)
    solution = _solve(better.shape_of_kind, kind, lines, MAX_STEPS)
    # Misfit that no shape explains is estimated with a shape for every layer.
    every = np.arange(n_layers)
    alone = _solve(solution.shape_of_kind[kind], every, lines, STEPS_ALONE)
    lasting = lasting_misfit(alone.shape_of_kind, lines)
    for _ in range(MAX_ROUNDS):
        own = departing(solution.equations, cluster, kind, lasting)
        if not own.any():
            break
        shared = solution.shape_of_kind[kind[own]]
        start = np.concatenate([solution.shape_of_kind, shared])
        kind = np.where(own, kind.max() + np.cumsum(own), kind)
        solution = _solve(start, kind, lines, MAX_STEPS)
    shape = solution.shape_of_kind[kind]
    covariance = _covariance(solution.equations, cluster, kind)
    powers, modelled = _powers(shape, groups)
    scatter = nan_moments(powers).standard_error
    leverage = solution.equations.leverage
    by_shape = np.einsum("li,ij,lj->l", leverage, covariance, leverage)
    return Deblended(
        shape=shape,
        shape_error=np.sqrt(np.diag(covariance)).reshape(n_layers, 3),
        powers=powers,
        power_error=np.sqrt(scatter**2 + by_shape),
        own_shape=kind > 1,
        modelled=modelled,
    )


def _spread_out(present):
    """Groups to fit shapes to, sorted.

    Each layer, deepest first, takes evenly spaced ones until it has enough.
    """
    chosen = np.zeros(len(present), dtype=bool)
    for layer in reversed(range(present.shape[1])):
        missing = SHAPE_GROUPS - int((chosen & present[:, layer]).sum())
        spare = np.flatnonzero(present[:, layer] & ~chosen)
        n_taken = min(missing, spare.size)
        if n_taken > 0:
            taken = np.linspace(0, spare.size - 1, n_taken).round().astype(int)
            chosen[spare[taken]] = True
    return np.flatnonzero(chosen)


def _starts(decay_rate, kind):
    """First guesses (kind, 3): the decay rates of eq. (2), narrow and wide."""
    start = np.tile([np.mean(FIRST_DECAY), 0.0, 0.0], (kind.max() + 1, 1))
    for k, shape in enumerate(start):
        measured = decay_rate[:, kind == k]
        measured = measured[measured > 0]
        if measured.size:
            shape[0] = np.clip(np.log(np.median(measured)), *FIRST_DECAY)
    return [start + [0.0, np.log(variance), 0.0] for variance in FIRST_VARIANCES]


@dataclass(frozen=True)
class NormalEquations:
    """What a Gauss-Newton step needs, at the shapes of all layers."""

    hessian: np.ndarray  # (3 layer, 3 layer)
    scores: np.ndarray  # gradient of each line, (line, 3 layer)
    leverage: np.ndarray  # mean change of the powers with the shapes, (layer, 3 layer)
    deviation: float  # standard deviation of the residuals, from their median
    loss: float  # mean over the residuals


@dataclass(frozen=True)
class Solution:
    """Shapes by kind of layer (kind, 3), and the equations of the last step."""

    shape_of_kind: np.ndarray
    equations: NormalEquations


def _solve(start, kind, lines, n_steps):
    """`Solution` from a start (kind, 3), by Gauss-Newton steps that each reweight the residuals."""
    for line in lines:
        line.scale = line.smooth
    shape = start
    last = np.inf
    deviation = np.inf
    for _ in shown(range(n_steps), unit="step"):
        equations = _normal_equations(shape[kind], lines, deviation)
        deviation = equations.deviation
        step = _step(equations, kind, shape - start)
        moved = np.clip(shape + step, LOWER, UPPER) - shape
        shape = shape + moved
        gained = abs(last - equations.loss)
        if np.abs(moved).max() < STEP_TOLERANCE or gained < RESIDUAL_TOLERANCE * last:
            break
        last = equations.loss
    return Solution(shape, equations)


def _of_kind(kind):
    """Matrix from shapes by kind to shapes by layer, (3 layer, 3 kind)."""
    return np.kron(np.eye(kind.max() + 1)[kind], np.eye(3))


def _step(equations, kind, departure):
    """Gauss-Newton step of the shapes (kind, 3), held by a prior about their start."""
    spread = _of_kind(kind)
    prior = np.tile(PRIOR_DEVIATION, len(departure))
    information = equations.deviation**2 / prior**2
    matrix = spread.T @ equations.hessian @ spread
    matrix[np.diag_indices_from(matrix)] += information
    gradient = spread.T @ equations.scores.sum(axis=0) - information * departure.ravel()
    step = np.linalg.solve(matrix, gradient).reshape(-1, 3)
    # Scaled as a whole, a step keeps its direction; by kind, so that one bad layer does not slow
    # the others.
    excess = (np.abs(step) / LONGEST_STEP).max(axis=1, keepdims=True)
    return step / np.maximum(1, excess)


def _covariance(equations, cluster, kind):
    """Covariance of the shapes of all layers, (3 layer, 3 layer), misfit included."""
    spread = _of_kind(kind)
    by_line = equations.scores @ spread
    by_cluster = clustered(by_line, cluster)
    n_clusters = len(by_cluster)
    # Correlation within clusters, as a mean over shapes: there are too few clusters to estimate it
    # for each.
    independent = np.maximum((by_line**2).sum(axis=0), 1e-300)
    lasting = np.mean((by_cluster**2).sum(axis=0) / independent)
    inflation = max(lasting * n_clusters / max(n_clusters - 1, 1), 1)
    by_layer = np.zeros((kind.size, kind.max() + 1, 3))
    by_layer[np.arange(kind.size), kind] = equations.scores.sum(axis=0).reshape(-1, 3)
    by_layer = by_layer.reshape(kind.size, -1)
    scatter = by_line.T @ by_line * inflation + by_layer.T @ by_layer
    matrix = spread.T @ equations.hessian @ spread
    matrix[np.diag_indices_from(matrix)] += RIDGE * np.trace(matrix)
    inverse = np.linalg.inv(matrix)
    return spread @ inverse @ scatter @ inverse @ spread.T


def _normal_equations(shape, lines, deviation):
    """`NormalEquations` at shapes (layer, 3).

    The residuals' weights follow from the `deviation` of the step before.
    """
    n_layers = len(shape)
    described = describe(shape)
    hessian = np.zeros((3 * n_layers, 3 * n_layers))
    scores = np.zeros((len(lines), 3 * n_layers))
    leverage = np.zeros((n_layers, 3 * n_layers))
    n_lines = np.zeros(n_layers)
    residuals = []
    for score, line in zip(scores, lines, strict=True):
        fit = _fit_line(described, line, deviation)
        layers = line.layers[line.picked]
        at = (3 * layers[:, None] + np.arange(3)).ravel()
        hessian[at[:, None], at] += fit.hessian
        leverage[layers[:, None], at] += fit.leverage
        n_lines[layers] += 1
        score[at] = fit.score
        residuals.append(fit.residual)
        rescale(line, fit.model)
    leverage /= np.maximum(n_lines, 1)[:, None]
    residuals = np.concatenate(residuals)
    deviation = max(np.median(np.abs(residuals)) / NORMAL_MEDIAN, LEAST_DEVIATION)
    in_deviations = residuals / (CAUCHY * deviation)
    above = np.maximum(in_deviations, 0)
    below = np.maximum(-in_deviations, 0)
    loss = (np.log1p(above**2) + below**2).mean() * deviation**2
    return NormalEquations(hessian, scores, leverage, deviation, loss)


@dataclass(frozen=True)
class LineFit:
    """One line solved for its powers, and what it says of the shapes of its picked layers."""

    model: np.ndarray  # power above noise, (row,)
    residual: np.ndarray  # over the line's scale, (row,)
    hessian: np.ndarray  # (3 picked, 3 picked)
    score: np.ndarray  # (3 picked,)
    leverage: np.ndarray  # (picked, 3 picked)


def _fit_line(described, line, deviation):
    columns = waveform_columns(described, line, with_slopes=True)
    linear = np.concatenate([columns[0], line.background])
    powers, _ = solve_powers(linear, line, line.scale)
    relative = (line.signal - powers @ linear) / line.scale
    # Solved again with less weight on residuals above the model.
    above = np.maximum(relative, 0) / (CAUCHY * deviation)
    scale = line.scale * np.sqrt(1 + above**2)
    powers, factor = solve_powers(linear, line, scale)
    model = powers @ linear
    left = line.signal - model
    # Unpicked layers between picks help to explain the line, but at guessed rows do not constrain
    # their shape.
    n_layers = line.layers.size
    slopes = (columns[1:] * powers[:n_layers, None] / scale)[:, line.picked]
    slopes = slopes.transpose(1, 0, 2).reshape(-1, line.rows.size)
    mixed = linear / scale @ slopes.T
    # How the powers follow the shapes: eliminated from the matrix.
    by_shape = dpotrs(factor, mixed)[0]
    return LineFit(
        model=model,
        residual=left / line.scale,
        hessian=slopes @ slopes.T - mixed.T @ by_shape,
        score=slopes @ (left / scale),
        leverage=-by_shape[:n_layers][line.picked],
    )


def _powers(shape, groups):
    """Peak powers of all groups, (group, layer), NaN where a layer was not picked.

    And their lines as first fitted, (group, row), with the noise, in the rows the fit used; NaN
    elsewhere.
    """
    powers = np.full(groups.present.shape, np.nan)
    modelled = np.full(groups.power.shape, np.nan)
    described = describe(shape)
    for group in shown(range(len(powers)), unit="averaged line"):
        line = prepare_line(groups, group)
        if line is None:
            continue
        columns = np.concatenate([waveform_columns(described, line), line.background])
        first, _ = solve_powers(columns, line, line.scale)
        model = first @ columns
        modelled[group, line.rows - FIRST_ROW] = model + groups.noise_power
        rescale(line, model)
        second, _ = solve_powers(columns, line, line.scale)
        powers[group, line.layers] = second[: line.layers.size]
    return np.where(groups.present, powers, np.nan), modelled
