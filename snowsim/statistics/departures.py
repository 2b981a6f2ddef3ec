"""Which layers have a waveform of their own: gain of a separate shape against the gain that unpicked echoes cause."""

import numpy as np

from snowsim.phy.waveform import waveform_exact
from snowsim.statistics.lines import describe, solve_powers, waveform_columns

MISFIT_LAGS = np.arange(-3, 13)  # [bins] of a layer's echo over which misfit is looked for
ECHO_LAGS = np.arange(-8, 13)  # [bins] from the layer, where unpicked echoes lie that overlap it
MISFIT_LINES = 10  # averaged lines needed to estimate it
LEAST_SHARE = 0.02  # of an echo's squared profile that must remain


def clustered(scores, cluster):
    """Scores summed over each cluster of lines, (cluster, 3 layer)."""
    return np.array([scores[cluster == c].sum(axis=0) for c in np.unique(cluster)])


def lasting_misfit(shape, lines):
    """Variance per line of a layer's score from unpicked echoes that persist along the flight, (layer,).

    Such an echo has the shared waveform and lies anywhere about the layer. Its strength is what the
    mean profile of residuals at `MISFIT_LAGS` has beyond the layer's own power and shape and beyond
    speckle, in the layer with most of it. From that follows the part that looks like another shape.
    """
    n_layers, described = len(shape), describe(shape)
    profiles, n_lines, squares = np.zeros((n_layers, 6, MISFIT_LAGS.size)), np.zeros(n_layers), []
    for line in lines:
        columns = waveform_columns(described, line, with_slopes=True)
        linear = np.concatenate([columns[0], line.background])
        powers, _ = solve_powers(linear, line)
        residual = (line.signal - powers @ linear) / line.scale
        squares.append(
            np.median(residual**2) / 0.455
        )  # the median of chi-square with one degree of freedom
        for i in np.flatnonzero(line.picked):
            rows = np.searchsorted(line.rows, np.rint(line.position[i].mean()) + MISFIT_LAGS)
            if rows[-1] < line.rows.size and np.ptp(line.rows[rows]) == np.ptp(MISFIT_LAGS):
                own = np.vstack(
                    [columns[:, i, rows] * powers[i], np.full(rows.size, line.scale[rows].mean())]
                )
                own /= line.scale[rows]
                profiles[line.layers[i]] += np.vstack([residual[rows], own])
                n_lines[line.layers[i]] += 1
    seen = np.flatnonzero(n_lines >= MISFIT_LINES)
    strength, alike = [0.0], np.zeros(n_layers)
    free = MISFIT_LAGS.size - 4
    for layer in seen:
        residual, *explained, weight = profiles[layer] / n_lines[layer]
        lag = MISFIT_LAGS[:, None] - ECHO_LAGS - described.offset[layer] + described.peak[layer]
        echo = (
            waveform_exact(lag, described.variance[layer], described.decay[layer])
            / described.height[layer]
        )
        echo *= weight[:, None]
        basis = np.linalg.qr(np.array(explained).T)[0]  # its own power first, then its shape
        part = basis.T @ echo
        # Speckle's share, and four standard deviations of it.
        speckle = np.mean(squares) / n_lines[layer] * (free + 4 * np.sqrt(2 * free))
        left = (residual**2).sum() - ((basis.T @ residual) ** 2).sum() - speckle
        remains = (echo**2).sum() - (part**2).sum()
        # For a wide waveform, a change of shape can explain nearly all of an echo: the rest is too
        # small to use.
        if remains > LEAST_SHARE * (echo**2).sum():
            strength.append(left / remains)
        alike[layer] = (part[1:] ** 2).sum() / 3
    return alike * max(strength)


def departing(solution, cluster, kind, lasting):
    """Buried layers whose scores favour a shape of their own, bool (layer,).

    ``s' H^-1 s / phi`` is what a layer gains by its own shape, s its score at the shared one and H
    its part of the matrix. Rows are not independent, because unpicked echoes persist along track:
    phi is the mean over layers of ``tr(H^-1 B) / 3``, B the scatter of s between clusters, plus the
    variance `lasting (layer,)` for each line, because some echoes persist as long as the layer. The
    Bayesian information criterion requires 3 log(n) of n clusters.
    """
    summed = clustered(solution.scores, cluster).reshape(-1, kind.size, 3)
    blocks = solution.hessian.reshape(kind.size, 3, kind.size, 3)
    n_lines = (np.abs(solution.scores.reshape(-1, kind.size, 3)).sum(axis=2) > 0).sum(axis=0)
    gain, inflation, n_seen = np.zeros(kind.size), [], 0
    for layer in np.flatnonzero(kind == 1):
        held = summed[np.abs(summed[:, layer]).sum(axis=1) > 0, layer]
        if len(held) < 2:
            continue
        inverse = np.linalg.pinv(blocks[layer, :, layer])
        score = held.sum(axis=0)
        gain[layer] = score @ inverse @ score
        inflation.append(np.trace(inverse @ np.cov(held.T)) * len(held) / 3)
        n_seen += len(held)
    if len(inflation) < 2:
        return np.zeros(kind.size, dtype=bool)
    return gain > 3 * np.log(n_seen) * (np.mean(inflation) + n_lines * lasting)
