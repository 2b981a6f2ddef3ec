"""Which layers have a waveform of their own.

The gain of a separate shape is held against the gain that unpicked echoes cause.
"""

from dataclasses import dataclass

import numpy as np

from snowsim.phy.waveform import waveform_exact
from snowsim.statistics.lines import describe, solve_powers, waveform_columns

MISFIT_LAGS = np.arange(-3, 13)  # [bins] of a layer's echo over which misfit is looked for
ECHO_LAGS = np.arange(-8, 13)  # [bins] from the layer, where unpicked echoes lie that overlap it
MISFIT_LINES = 10  # averaged lines needed to estimate it
LEAST_SHARE = 0.02  # of an echo's squared profile that must remain
N_OWN = 4  # profiles that a layer's own power and three shape parameters explain
CHI_SQUARE_MEDIAN = 0.455  # of one degree of freedom
SPECKLE_DEVIATIONS = 4.0  # by which misfit must exceed speckle


def clustered(scores, cluster):
    """Scores summed over each cluster of lines, (cluster, 3 layer)."""
    return np.array([scores[cluster == c].sum(axis=0) for c in np.unique(cluster)])


def lasting_misfit(shape, lines):
    """Variance per line of a layer's score from unpicked echoes that persist, (layer,).

    Such an echo has the shared waveform and lies anywhere about the layer. Its strength is what the
    mean profile of residuals at `MISFIT_LAGS` has beyond the layer's own power and shape and beyond
    speckle, in the layer with most of it. From that follows the part that looks like another shape.
    """
    described = describe(shape)
    profiles = _profiles(described, lines)
    free = MISFIT_LAGS.size - N_OWN
    chance = free + SPECKLE_DEVIATIONS * np.sqrt(2 * free)
    strength = [0.0]
    alike = np.zeros(len(shape))
    for layer in np.flatnonzero(profiles.n_lines >= MISFIT_LINES):
        n_lines = profiles.n_lines[layer]
        residual = profiles.residual[layer] / n_lines
        own = profiles.own[layer] / n_lines
        weight = profiles.weight[layer] / n_lines
        here = described.of(layer)
        lag = MISFIT_LAGS[:, None] - ECHO_LAGS - here.offset + here.peak
        echo = waveform_exact(lag, here.variance, here.decay) / here.height * weight[:, None]
        basis = np.linalg.qr(own.T)[0]  # its own power first, then its shape
        explained = basis.T @ residual
        part = basis.T @ echo
        speckle = profiles.square / n_lines * chance
        left = (residual**2).sum() - (explained**2).sum() - speckle
        whole = (echo**2).sum()
        remains = whole - (part**2).sum()
        # For a wide waveform, a change of shape can explain nearly all of an echo: the rest is too
        # small to use.
        if remains > LEAST_SHARE * whole:
            strength.append(left / remains)
        alike[layer] = (part[1:] ** 2).sum() / 3
    return alike * max(strength)


@dataclass(frozen=True)
class Profiles:
    """Sums over lines of what is seen at `MISFIT_LAGS` from each layer, over the lines' scale."""

    residual: np.ndarray  # (layer, lag)
    own: np.ndarray  # waveform of its power and slopes of its shape, (layer, N_OWN, lag)
    weight: np.ndarray  # of an echo as strong as the mean scale, (layer, lag)
    n_lines: np.ndarray  # (layer,)
    square: float  # mean square of a line's residuals


def _profiles(described, lines):
    n_layers = described.decay.size
    residuals = np.zeros((n_layers, MISFIT_LAGS.size))
    owns = np.zeros((n_layers, N_OWN, MISFIT_LAGS.size))
    weights = np.zeros((n_layers, MISFIT_LAGS.size))
    n_lines = np.zeros(n_layers)
    squares = []
    for line in lines:
        columns = waveform_columns(described, line, with_slopes=True)
        linear = np.concatenate([columns[0], line.background])
        powers, _ = solve_powers(linear, line, line.scale)
        residual = (line.signal - powers @ linear) / line.scale
        squares.append(np.median(residual**2) / CHI_SQUARE_MEDIAN)
        for i in np.flatnonzero(line.picked):
            pick = np.rint(line.position[i].mean())
            rows = np.searchsorted(line.rows, pick + MISFIT_LAGS)
            if rows[-1] >= line.rows.size:
                continue
            if np.ptp(line.rows[rows]) != np.ptp(MISFIT_LAGS):
                continue
            layer = line.layers[i]
            scale = line.scale[rows]
            residuals[layer] += residual[rows]
            owns[layer] += columns[:, i, rows] * powers[i] / scale
            weights[layer] += scale.mean() / scale
            n_lines[layer] += 1
    return Profiles(residuals, owns, weights, n_lines, np.mean(squares))


def departing(equations, cluster, kind, lasting):
    """Buried layers whose scores favour a shape of their own, bool (layer,).

    ``s' H^-1 s / phi`` is what a layer gains by its own shape, s its score at the shared one and H
    its part of the matrix. Rows are not independent, because unpicked echoes persist along track:
    phi is the mean over layers of ``tr(H^-1 B) / 3``, B the scatter of s between clusters, plus the
    variance `lasting (layer,)` for each line, because some echoes persist as long as the layer. The
    Bayesian information criterion requires 3 log(n) of n clusters.
    """
    n_layers = kind.size
    by_cluster = clustered(equations.scores, cluster).reshape(-1, n_layers, 3)
    blocks = equations.hessian.reshape(n_layers, 3, n_layers, 3)
    in_line = equations.scores.reshape(-1, n_layers, 3).any(axis=2)
    gain = np.zeros(n_layers)
    inflation = []
    n_seen = 0
    for layer in np.flatnonzero(kind == 1):
        scores = by_cluster[:, layer]
        scores = scores[scores.any(axis=1)]
        n_clusters = len(scores)
        if n_clusters < 2:
            continue
        inverse = np.linalg.pinv(blocks[layer, :, layer])
        score = scores.sum(axis=0)
        gain[layer] = score @ inverse @ score
        inflation.append(np.trace(inverse @ np.cov(scores.T)) * n_clusters / 3)
        n_seen += n_clusters
    if len(inflation) < 2:
        return np.zeros(n_layers, dtype=bool)
    phi = np.mean(inflation) + in_line.sum(axis=0) * lasting
    return gain > 3 * np.log(n_seen) * phi
