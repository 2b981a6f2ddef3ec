"""Averaged range lines with the layers in them, as linear models: waveforms of eq. (1) and a background."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dposv
from scipy.ndimage import uniform_filter1d

from snowsim.phy.waveform import waveform_exact, waveform_peak
from snowsim.statistics.paper import OPEN_END_BINS
from snowsim.statistics.summaries import FIRST_ROW

RISE_DEVIATIONS = 7.0  # above its peak, a waveform is cut at 1e-10 of the peak
FALL_NEPERS = 14.0  # and below it at 1e-6
BACKGROUND_FALLS = (
    30.0,
    100.0,
    1000.0,
)  # [bins] e-folding depths of unpicked scatter; sums of them fit most declines
BACKGROUND_RISE = 0.1  # [per bin] how fast it sets in below the surface: about a waveform's decay
ECHO_ROOM = (
    14.0  # [bins] between two picks from which on snow between them has an echo of its own, halfway
)
ECHO_VARIANCE = 0.6  # [bins^2] of its Gaussian: about that of the range response


@dataclass(frozen=True)
class Groups:
    """Averaged range lines of a flight with the layers in them."""

    power: (
        np.ndarray
    )  # (group, row), rows from `FIRST_ROW` below the surface; NaN outside the record
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
    picked: np.ndarray  # (layer,), False for unpicked layers between picked ones
    background: np.ndarray  # columns of unpicked snow, (column, row)
    scale: np.ndarray  # residuals are weighted by 1 / scale^2, (row,)


def prepare_line(groups, group):
    """The group as `Line`, down to half a slab below its last pick; None without a picked layer to fit."""
    rows = np.arange(groups.power.shape[1]) + FIRST_ROW
    picked = np.flatnonzero(groups.present[group])
    if picked.size == 0:
        return None
    layers = np.arange(picked[0], picked[-1] + 1)
    position, spread = (
        _between(layers, picked, part[group, picked]) for part in (groups.position, groups.spread)
    )
    last = position[-1].mean()
    below = (last - position[-2].mean()) / 2 if layers.size > 1 else OPEN_END_BINS
    with np.errstate(invalid="ignore"):
        used = (rows <= last + below) & np.isfinite(groups.power[group])
    signal = groups.power[group, used].astype(float) - groups.noise_power
    if signal.size <= 2 * layers.size:
        return None
    smooth = np.maximum(
        uniform_filter1d(signal, 9, mode="nearest") + groups.noise_power, groups.noise_power
    )
    background = _background_columns(rows[used], position.mean(axis=1), layers[0] == 0)
    within = (
        rows[used],
        signal,
        groups.noise_power,
        smooth,
        layers,
        position,
        spread,
        np.isin(layers, picked),
    )
    return Line(*within, background, smooth)


def _between(layers, picked, values):
    """Values (layer, part) of picked layers, interpolated linearly for those between."""
    return np.column_stack([np.interp(layers, picked, part) for part in values.T])


def waveform_columns(described, line, *, with_slopes=False):
    """Waveforms of unit peak of a line, (layer, row); with slopes by the three columns of `shape`, (4, layer, row).

    The slopes follow from eq. (1): ``dw/dx = g - a w`` and ``dw/da = -((x - a d) w + d g)`` for its
    Gaussian g, and ``dw/dd = w / 2d + w'' / 2``, as the Gaussian obeys the heat equation. At the
    peak x0, where ``g = a w``, they give its height, ``d log w0 / d log a = -a x0``, ``d log w0 / d
    log d = (1 - a x0) / 2``, and, by w' = 0, its movement.
    """
    position, spread = line.position.T[:, :, None], line.spread.T[:, :, None]
    lag = line.rows - (position + (described.offset - described.peak)[line.layers][:, None])
    wide = described.variance[line.layers][:, None] + spread
    reached = (lag > -RISE_DEVIATIONS * np.sqrt(wide)) & (
        lag * described.decay[line.layers][:, None] < FALL_NEPERS
    )
    part, of = np.nonzero(reached)[:2]
    lag, layer, wide = lag[reached], line.layers[of], wide[part, of, 0]
    decay, variance, peak = described.decay[layer], described.variance[layer], described.peak[layer]
    raw = waveform_exact(lag, wide, decay)
    unit = np.sqrt(variance / wide) / described.height[layer]
    values = [unit * raw]
    if with_slopes:
        gaussian = np.exp(-(lag**2) / (2 * wide))
        along = gaussian - decay * raw
        by_decay = -((lag - decay * wide) * raw + wide * gaussian)
        by_variance = raw / (2 * wide) - (lag / wide * gaussian + decay * along) / 2
        peak_by_decay = -variance * (1 - decay * peak) / peak
        peak_by_variance = (peak**2 - variance + decay * variance * peak) / (2 * peak)
        values.append(unit * (decay * by_decay + along * peak_by_decay + raw * (decay * peak)))
        height_by_variance = (decay * peak - variance / wide) / 2
        values.append(
            unit * (variance * by_variance + along * peak_by_variance + raw * height_by_variance)
        )
        values.append(-(unit * along))
    columns = np.zeros((len(values), *reached.shape))
    for column, filled in zip(columns, values, strict=True):
        column[reached] = filled
    columns = columns.sum(axis=1) / len(reached)
    return columns if with_slopes else columns[0]


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


def solve_powers(columns, line, scale=None):
    """Least-squares powers of a line, (layer,), by its scale or another; upper Cholesky factor of the normal matrix."""
    scale = line.scale if scale is None else scale
    weighted = columns / scale
    normal = weighted @ weighted.T
    # Coincident layers cannot be separated: 1e-9 of the diagonal keeps the matrix invertible, far
    # below the noise.
    diagonal = np.einsum("ii->i", normal)  # a view
    diagonal *= 1 + 1e-9
    diagonal += 1e-300
    factor, powers, refused = dposv(
        normal, weighted @ (line.signal / scale)
    )  # SciPy's own checks cost as much
    if refused:
        msg = f"normal matrix of a line of {len(columns)} columns is not positive definite"
        raise np.linalg.LinAlgError(msg)
    return powers, factor


def rescale(line, model):
    """Scale of the next step's weights: the expected mean power, but never below the smoothed one."""
    line.scale = np.maximum(model + line.noise_power, line.smooth)


def _background_columns(rows, pick, has_surface):
    """Power of unpicked snow, no free shape: by e-folding depth of its decline, then an echo a slab, (column, row).

    Power from scatterers of density exp(-z / fall) is that exponential less the waveform's,
    ``exp(-rise z)``. It keeps a decline that continues below a layer's own decay from being taken
    for the layer's; so does an echo halfway between two picks with the power of crusts there. One
    is enough: many could stand for a slower decay.
    """
    depth = np.maximum(rows - (pick[0] if has_surface else 0.0), 0)
    declines = [
        np.exp(-depth / fall) - np.exp(-BACKGROUND_RISE * depth) for fall in BACKGROUND_FALLS
    ]
    echo = (pick[:-1] + np.diff(pick) / 2)[np.diff(pick) >= ECHO_ROOM]
    return np.concatenate(
        [declines, waveform_exact(rows - echo[:, None], ECHO_VARIANCE, BACKGROUND_RISE)]
    )
