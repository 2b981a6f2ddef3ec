"""Deblending: powers and waveforms of eq. (1), fitted to all layers of averaged lines jointly."""

import warnings
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.linalg.lapack import dposv, dpotrs
from scipy.ndimage import uniform_filter1d
from scipy.optimize import least_squares

from snowsim.phy.waveform import waveform_exact, waveform_peak, waveform_width
from snowsim.progress import with_progress
from snowsim.statistics.groups import (
    OPEN_END_BINS,
    TYPICAL_DECAY_RATE,
    powers_of_all_layers,
)
from snowsim.statistics.summaries import FIRST_ROW, known_mean, rows_from

# Averaged lines that the shape of a layer is fitted to. With 100 looks a line, the error of a decay
# rate is 1.5 %.
SHAPE_GROUPS = 60
# A waveform begins `RISE_DEVIATIONS` standard deviations of its Gaussian above the centre, at 1e-10
# of the peak. It ends `FALL_NEPERS` e-foldings of its decay further down than as many deviations
# below the centre, at 1e-5.
RISE_DEVIATIONS = 7.0
FALL_NEPERS = 12.0
SMOOTH_ROWS = 9  # length of the moving mean of power that first weighs the residuals
# [bins] e-folding depths of unpicked scatter; sums of such exponentials fit most declines.
BACKGROUND_FALLS = np.array([30.0, 100.0, 1000.0])
# [bins] Snow between two picks at least this far apart has an echo of its own, halfway.
ECHO_ROOM = 14.0
ECHO_VARIANCE = 0.6  # [bins^2] of that echo's Gaussian: about the range response's
LEAST_DEVIATION = 1e-6  # of relative residuals: lines without speckle have almost none
# Limits of a shape: log decay rate, log variance, and offset of the peak below the pick [bins].
LOWER = np.array([np.log(2e-3), np.log(0.25), -15.0])
UPPER = np.array([np.log(2.0), np.log(200.0), 15.0])
PRIOR_DEVIATION = np.array([1.0, 1.5, 4.0])  # standard deviation of a shape about its start
FIRST_DECAY = np.log([0.05, 0.5])  # limits of the decay rate at the start, log of [per bin]
# [bins^2] The fit starts from a waveform as narrow as the range response: from a wide one it may
# end at a surface that is much too wide, whose peak counts as an unpicked echo.
FIRST_VARIANCE = 0.7
MOST_STEPS = 4  # evaluations of the residuals in one round
MOST_ROUNDS = 4  # each round weighs the residuals anew
# A fit has settled when log decay, log variance and offset [bins] change by less than this: a
# tenth of the smallest error allowed in them.
SETTLED = 5e-3
WAVEFORM_LAGS = np.arange(-20, 61)  # of mean waveforms [bins below the pick]
LEAST_ERRORS = 2.0  # a mean power is reliable above this many of its standard errors


@dataclass
class Line:
    """One averaged line as the fit takes it."""

    rows: np.ndarray  # rows used in the fit, (row,)
    signal: np.ndarray  # power above noise, (row,)
    layers: np.ndarray  # numbers of its layers, (layer,)
    position: np.ndarray  # (layer, part)
    spread: np.ndarray  # (layer, part)
    picked: np.ndarray  # (layer,), False for unpicked layers between picked ones
    background: np.ndarray  # columns of unpicked snow, (column, row)
    noise_power: float
    smooth: np.ndarray  # smoothed power, (row,)
    scale: np.ndarray  # residuals are weighted by 1 / scale^2, (row,)

    @property
    def kind(self):
        """Number of each layer's shape, (layer,): 0 for the surface, 1 for buried layers."""
        return np.minimum(self.layers, 1)


def deblend(groups, decay_rate):
    """Shapes of the waveforms of a flight, as variables of a dataset, and powers (group, layer).

    Both are fitted to all layers of `Groups` jointly. `decay_rate` (group, layer) holds the rates
    of eq. (2), NaN where they are unknown; the fit starts from their medians.

    The model of a group's mean power is ``P(x) = noise + background + sum_l p_l w(x - x_l - c; d +
    v_l, alpha)``, with the waveform w of eq. (1) of Yari et al. (2021), averaged over the parts of
    a group. Within a part the rows of a layer have the variance v_l, which to second order only
    widens the Gaussian. The powers p_l and those of `Line.background` are free in every group and
    linear, so they are eliminated (variable projection, Kaufman 1975, BIT 15, 49-57).

    A shape is a log decay rate, a log variance and the distance c of the waveform's peak below the
    pick. Least squares find one shape for the surface and one for all buried layers. A broad prior
    (`PRIOR_DEVIATION`) holds parameters that the data do not constrain. Residuals have the weight
    1 / P^2 because of speckle. Positive ones weigh less, as under Cauchy's law, because unpicked
    echoes only add to the waveforms. An unpicked layer between two picked ones is fitted too, at an
    interpolated row; a line ends soon below its last pick, because nothing deeper is annotated.
    """
    lines = [prepare_line(groups, group) for group in _spread_out(groups.present)]
    lines = [line for line in lines if line is not None]
    start = np.tile([FIRST_DECAY.mean(), np.log(FIRST_VARIANCE), 0.0], (2, 1))
    for shape, measured in zip(start, (decay_rate[:, 0], decay_rate[:, 1:]), strict=True):
        measured = measured[measured > 0]
        if measured.size:
            shape[0] = np.clip(np.log(np.median(measured)), *FIRST_DECAY)
    shape = _fit_shapes(start, lines)
    of_layers = shape[np.minimum(np.arange(groups.present.shape[1]), 1)]
    decay_rate, variance = np.exp(of_layers[:, :2].T)
    variables = {
        "decay_rate": ("layer", decay_rate),
        "width_bins": ("layer", waveform_width(variance, decay_rate)),
        "variance_bins2": ("layer", variance),
        "offset_bins": ("layer", of_layers[:, 2]),
    }
    _, height = waveform_peak(variance, decay_rate)
    powers = np.full(groups.present.shape, np.nan)
    for group in with_progress(range(len(powers)), unit="averaged line"):
        line = prepare_line(groups, group)
        if line is not None:
            solved, _ = _explained(shape, line)
            powers[group, line.layers] = solved[: line.layers.size]
    powers = np.where(groups.present, powers * height / np.sqrt(variance), np.nan)
    return variables, powers


def _spread_out(present):
    """Numbers of the groups to which shapes are fitted, sorted.

    Each layer, deepest first, adds evenly spaced groups until it has `SHAPE_GROUPS`.
    """
    chosen = np.zeros(len(present), dtype=bool)
    for layer in reversed(range(present.shape[1])):
        missing = SHAPE_GROUPS - int((chosen & present[:, layer]).sum())
        spare = np.flatnonzero(present[:, layer] & ~chosen)
        n_taken = max(min(missing, spare.size), 0)
        taken = np.linspace(0, spare.size - 1, n_taken).round().astype(int)
        chosen[spare[taken]] = True
    return np.flatnonzero(chosen)


def prepare_line(groups, group):
    """One group as a `Line`, down to half a slab below its last pick.

    None if no layer is picked, or if there are too few rows for the layers.
    """
    picked = np.flatnonzero(groups.present[group])
    if picked.size == 0:
        return None
    layers = np.arange(picked[0], picked[-1] + 1)
    parts = np.hstack([groups.position[group, picked], groups.spread[group, picked]])
    # Layers between picked ones are interpolated linearly.
    between = [np.interp(layers, picked, part) for part in parts.T]
    position, spread = np.hsplit(np.transpose(between), 2)
    pick = position.mean(axis=1)
    below = (pick[-1] - pick[-2]) / 2 if layers.size > 1 else OPEN_END_BINS
    rows = np.arange(groups.power.shape[1]) + FIRST_ROW
    used = (rows <= pick[-1] + below) & np.isfinite(groups.power[group])
    signal = groups.power[group, used].astype(float) - groups.noise_power
    if signal.size <= 2 * layers.size:
        return None
    rows = rows[used]
    smooth = uniform_filter1d(signal, SMOOTH_ROWS, mode="nearest")
    smooth = np.maximum(smooth, 0) + groups.noise_power
    # The columns of unpicked snow have fixed shapes. Scatterers whose density falls as
    # exp(-z / fall) give this exponential less the waveform's own. Their decline continues below
    # that of a layer and, without these columns, would be taken for the layer's decay. The power of
    # crusts between two picks would be, too: an echo halfway takes it up. One is enough, because
    # many could imitate a slower decay.
    depth = np.maximum(rows - (pick[0] if layers[0] == 0 else 0.0), 0)
    # Unpicked scatter sets in below the surface as fast as a waveform decays.
    declines = np.exp(-depth / BACKGROUND_FALLS[:, None]) - np.exp(-TYPICAL_DECAY_RATE * depth)
    slab = np.diff(pick)
    echo = (pick[:-1] + slab / 2)[slab >= ECHO_ROOM]
    echoes = waveform_exact(rows - echo[:, None], ECHO_VARIANCE, TYPICAL_DECAY_RATE)
    return Line(
        rows=rows,
        signal=signal,
        layers=layers,
        position=position,
        spread=spread,
        picked=np.isin(layers, picked),
        background=np.concatenate([declines, echoes]),
        noise_power=groups.noise_power,
        smooth=smooth,
        scale=smooth,
    )


def _fit_shapes(start, lines):
    """Shapes by kind of layer, (kind, 3), fitted from `start`; warns of those at a limit."""
    shape = start
    slopes_of = {}

    def residuals(unknown):
        parts = [separate(unknown.reshape(-1, 3), line) for line in lines]
        departure = (unknown - start.ravel()) / prior
        slopes_of["last"] = np.concatenate([part[1].T for part in parts] + [np.diag(1 / prior)])
        return np.concatenate([part[0] for part in parts] + [departure])

    deviation = _weigh(shape, lines)
    for _ in with_progress(range(MOST_ROUNDS), unit="round"):
        prior = np.tile(PRIOR_DEVIATION, len(start)) / deviation
        # Slopes are asked for after a step is taken, at the shapes of the last residuals.
        solution = least_squares(
            residuals,
            np.clip(shape, LOWER + SETTLED, UPPER - SETTLED).ravel(),
            lambda _: slopes_of["last"],
            bounds=(np.tile(LOWER, len(start)), np.tile(UPPER, len(start))),
            xtol=SETTLED / 4,
            ftol=1e-5,
            max_nfev=MOST_STEPS,
        )
        moved = np.abs(solution.x.reshape(-1, 3) - shape).max()
        shape = solution.x.reshape(-1, 3)
        deviation = _weigh(shape, lines)
        if moved < SETTLED:
            break
    if not ((shape > LOWER + SETTLED) & (shape < UPPER - SETTLED)).all():
        msg = (
            "the waveform of the surface or of buried layers ends at a limit of its fit: look at "
            "decay_rate, variance_bins2 and offset_bins"
        )
        warnings.warn(msg, UserWarning, stacklevel=2)
    return shape


def _weigh(shape, lines):
    """Standard deviation of the relative residuals; also sets the scale of each line from them.

    The scale grows where power exceeds the model by more than the deviation: Cauchy's weights.
    """
    relative = []
    for line in lines:
        _, model = _explained(shape, line)
        relative.append((line.signal - model) / line.scale)
    together = np.concatenate(relative)
    # 0.6745 is the median magnitude of a standard normal variable.
    deviation = max(np.median(np.abs(together)) / 0.6745, LEAST_DEVIATION)
    for line, residual in zip(lines, relative, strict=True):
        line.scale = line.scale * np.hypot(1, np.maximum(residual, 0) / deviation)
    return deviation


def _explained(shape, line):
    """Powers of a line's columns, and the model that is their sum, (row,).

    The fit has no one-sided weights. It sets the line's scale to the mean power of the model, or to
    the smoothed power where that is larger.
    """
    waveforms = waveform_columns(shape, line, with_slopes=False)
    columns = np.concatenate([waveforms[0], line.background])
    for _ in range(2):
        powers, _ = solve_powers(columns, line)
        model = powers @ columns
        line.scale = np.maximum(model + line.noise_power, line.smooth)
    return powers, model


def separate(shape, line):
    """Weighted residuals of a line (row,), and their slopes by the shapes (kind, 3), (3 kind, row).

    Powers are eliminated from residuals and slopes. Unpicked layers between picks help to explain
    the line; since their rows are guessed, they do not constrain a shape.
    """
    columns = waveform_columns(shape, line)
    linear = np.concatenate([columns[0], line.background])
    powers, factor = solve_powers(linear, line)
    residual = (line.signal - powers @ linear) / line.scale
    slopes = np.zeros((*shape.shape, line.rows.size))
    for i in np.flatnonzero(line.picked):
        slopes[line.kind[i]] -= powers[i] * columns[1:, i] / line.scale
    slopes = slopes.reshape(-1, line.rows.size)
    linear = linear / line.scale
    return residual, slopes - dpotrs(factor, linear @ slopes.T)[0].T @ linear


def solve_powers(columns, line):
    """Least-squares powers (column,) of a line, and the Cholesky factor of the normal matrix."""
    weighted = columns / line.scale
    normal = weighted @ weighted.T
    # Coincident layers cannot be separated: 1e-9 of the diagonal keeps the matrix invertible, far
    # below the noise.
    diagonal = np.einsum("ii->i", normal)  # a view
    diagonal *= 1 + 1e-9
    diagonal += 1e-300
    # SciPy's own checks cost as much as the solution.
    factor, powers, refused = dposv(normal, weighted @ (line.signal / line.scale))
    assert not refused, "the normal matrix is positive definite"
    return powers, factor


def waveform_columns(shape, line, *, with_slopes=True):
    """Waveforms of a line for shapes (kind, 3), and their slopes by these, (4, layer, row).

    A waveform w is that of eq. (1), divided by the square root of its variance d, which includes
    the spread of its part. With the Gaussian g and the decay rate a, ``dw/dx = g - a w`` and
    ``dw/da = -((x - a d) w + d g)``; ``dw/dd = w'' / 2``, as the Gaussian obeys the heat equation.
    A shape holds the place of the waveform's peak, where w' = 0, which moves with a and d. If it
    held the place of the Gaussian, the loss would have a curved valley.
    """
    log_decay, log_variance, offset = shape[line.kind].T
    decay, variance = np.exp(log_decay), np.exp(log_variance)
    peak, _ = waveform_peak(variance, decay)
    lag = line.rows - (line.position.T + offset - peak)[:, :, None]
    wide = variance[:, None] + line.spread.T[:, :, None]
    reach = RISE_DEVIATIONS * np.sqrt(wide)
    reached = (lag > -reach) & ((lag - reach) * decay[:, None] < FALL_NEPERS)
    # From here on arrays hold, for all parts and layers, only the samples that a waveform reaches.
    part, layer, _ = np.nonzero(reached)
    lag, wide = lag[reached], wide[part, layer, 0]
    decay, variance, peak = decay[layer], variance[layer], peak[layer]
    wave = waveform_exact(lag, wide, decay)
    columns = np.zeros((4 if with_slopes else 1, *reached.shape))
    columns[0, reached] = wave / np.sqrt(wide)
    if not with_slopes:
        return columns.mean(axis=1)
    gaussian = np.exp(-(lag**2) / (2 * wide))
    along = gaussian - decay * wave
    by_decay = -((lag - decay * wide) * wave + wide * gaussian)
    bend = -lag / wide * gaussian - decay * along
    peak_by_decay = -variance * (1 - decay * peak) / peak
    peak_by_variance = (peak**2 - variance + decay * variance * peak) / (2 * peak)
    by_decay = decay * by_decay + along * peak_by_decay
    by_variance = variance * bend / 2 + along * peak_by_variance
    columns[1:, reached] = [by_decay, by_variance, -along] / np.sqrt(wide)
    return columns.mean(axis=1)


def deblended_waveform(groups, tracked_power, decay):
    """Variables by layer of the joint solution, and powers (group, layer).

    `tracked_power` (layer,) is the mean power under the picks, 0 for layers without picks; `decay`
    (group, layer) holds the decay rates of eq. (2). A layer whose mean power is below two standard
    errors, by its scatter between groups, is `substituted`: it gets the tracked power above noise,
    times the median share of it that other layers keep in deblending. Such a power is always
    positive, so that it can be rendered.
    """
    variables, powers = deblend(groups, decay)
    by_layer = pd.DataFrame(powers)
    solved = by_layer.mean().to_numpy()
    # A single value has no error, and is not reliable.
    reliable = solved > LEAST_ERRORS * by_layer.sem().to_numpy()
    above_noise = np.maximum(tracked_power - groups.noise_power, 0)
    seen = above_noise > 0
    both = reliable & seen
    share = np.median(solved[both] / above_noise[both]) if both.any() else 1.0
    stand_in = share * np.where(seen, above_noise, groups.noise_power)
    peak_power = powers_of_all_layers(np.where(reliable, solved, stand_in), tracked_power > 0)
    variables |= {
        "peak_power": ("layer", peak_power),
        "substituted": ("layer", (~reliable).astype(np.int64)),
        "mean_waveform": (("layer", "lag"), _mean_waveforms(groups)),
    }
    return variables, powers


def _mean_waveforms(groups):
    """Mean power of averaged lines about each layer's row, (layer, lag), 0 where unknown."""
    means = []
    for row, present in zip(groups.row.T, groups.present.T, strict=True):
        first = np.rint(row[present]).astype(int) - FIRST_ROW + WAVEFORM_LAGS[0]
        lines = rows_from(groups.power[present], first, WAVEFORM_LAGS.size)
        means.append(known_mean(lines.astype(float), axis=0))
    return np.nan_to_num(means)
