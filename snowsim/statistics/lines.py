"""Averaged range lines with the layers in them, as linear models.

Their columns are waveforms of eq. (1) and a background.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dposv
from scipy.ndimage import uniform_filter1d

from snowsim.phy.waveform import waveform_exact, waveform_peak
from snowsim.statistics.paper import OPEN_END_BINS
from snowsim.statistics.summaries import FIRST_ROW

RISE_DEVIATIONS = 7.0  # above its peak, a waveform is cut at 1e-10 of the peak
FALL_NEPERS = 14.0  # and below it at 1e-6
SMOOTH_ROWS = 9  # of the moving mean that the weights follow
# [bins] e-folding depths of unpicked scatter; sums of them fit most declines.
BACKGROUND_FALLS = np.array([30.0, 100.0, 1000.0])
# [per bin] how fast it sets in below the surface: about a waveform's decay.
BACKGROUND_RISE = 0.1
# [bins] between two picks from which on snow between them has an echo of its own, halfway.
ECHO_ROOM = 14.0
ECHO_VARIANCE = 0.6  # [bins^2] of its Gaussian: about that of the range response


@dataclass(frozen=True)
class Groups:
    """Averaged range lines of a flight with the layers in them."""

    # (group, row), rows from `FIRST_ROW` below the surface; NaN outside the record:
    power: np.ndarray
    # (group, layer, part), NaN where absent: equal parts of a layer's lines in order of depth.
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
    """The group as `Line`, down to half a slab below its last pick.

    None without a picked layer to fit.
    """
    picked = np.flatnonzero(groups.present[group])
    if picked.size == 0:
        return None
    layers = np.arange(picked[0], picked[-1] + 1)
    position = _between(layers, picked, groups.position[group, picked])
    spread = _between(layers, picked, groups.spread[group, picked])
    pick = position.mean(axis=1)
    last = position[-1].mean()
    below = (last - position[-2].mean()) / 2 if layers.size > 1 else OPEN_END_BINS
    power = groups.power[group]
    rows = np.arange(power.size) + FIRST_ROW
    used = (rows <= last + below) & np.isfinite(power)
    signal = power[used].astype(float) - groups.noise_power
    if signal.size <= 2 * layers.size:
        return None
    smooth = uniform_filter1d(signal, SMOOTH_ROWS, mode="nearest") + groups.noise_power
    smooth = np.maximum(smooth, groups.noise_power)
    surface = pick[0] if layers[0] == 0 else 0.0
    return Line(
        rows=rows[used],
        signal=signal,
        noise_power=groups.noise_power,
        smooth=smooth,
        layers=layers,
        position=position,
        spread=spread,
        picked=np.isin(layers, picked),
        background=_background_columns(rows[used], pick, surface),
        scale=smooth,
    )


def _between(layers, picked, values):
    """Values (layer, part) of picked layers, interpolated linearly for those between."""
    return np.column_stack([np.interp(layers, picked, part) for part in values.T])


@dataclass(frozen=True)
class Described:
    """Waveforms of layers, (layer,)."""

    decay: np.ndarray  # rate [per bin]
    variance: np.ndarray  # [bins^2]
    offset: np.ndarray  # of the peak below the pick [bins]
    peak: np.ndarray  # below the Gaussian [bins]
    height: np.ndarray  # of the peak

    def of(self, layers):
        """The same of some layers, in the order given."""
        return Described(*(values[layers] for values in vars(self).values()))


def describe(shape):
    """`Described` of the layers of `shape (layer, 3)`.

    A shape is log decay rate, log variance and offset of the peak [bins].
    """
    decay = np.exp(shape[:, 0])
    variance = np.exp(shape[:, 1])
    peak, height = waveform_peak(variance, decay)
    return Described(decay, variance, shape[:, 2], peak, height)


def waveform_columns(described, line, *, with_slopes=False):
    """Waveforms of unit peak of a line, (layer, row).

    Or (4, layer, row), followed by the slopes by the three columns of `shape`.
    """
    here = described.of(line.layers)
    centre = line.position.T[:, :, None] + (here.offset - here.peak)[:, None]
    lag = line.rows - centre
    wide = here.variance[:, None] + line.spread.T[:, :, None]
    risen = lag > -RISE_DEVIATIONS * np.sqrt(wide)
    reached = risen & (lag * here.decay[:, None] < FALL_NEPERS)
    # From here on only the samples that the waveform reaches, of all parts and layers.
    part, layer, _ = np.nonzero(reached)
    sample = here.of(layer)
    wide = wide[part, layer, 0]
    lag = lag[reached]
    raw = waveform_exact(lag, wide, sample.decay)
    values = [raw, *_slopes(sample, lag, wide, raw)] if with_slopes else [raw]
    unit = np.sqrt(sample.variance / wide) / sample.height
    columns = np.zeros((len(values), *reached.shape))
    for column, value in zip(columns, values, strict=True):
        column[reached] = unit * value
    columns = columns.sum(axis=1) / len(reached)
    return columns if with_slopes else columns[0]


def _slopes(sample, lag, wide, raw):
    """Slopes by log decay rate, log variance and offset, of the waveform over its peak, times that.

    They follow from eq. (1): ``dw/dx = g - a w`` and ``dw/da = -((x - a d) w + d g)`` for its
    Gaussian g, and ``dw/dd = w / 2d + w'' / 2``, as the Gaussian obeys the heat equation. At the
    peak x0, where ``g = a w``, they give its height, ``d log w0 / d log a = -a x0``, ``d log w0 / d
    log d = (1 - a x0) / 2``, and, by w' = 0, its movement.
    """
    decay, variance, peak = sample.decay, sample.variance, sample.peak
    gaussian = np.exp(-(lag**2) / (2 * wide))
    along = gaussian - decay * raw
    by_decay = -((lag - decay * wide) * raw + wide * gaussian)
    by_variance = raw / (2 * wide) - (lag / wide * gaussian + decay * along) / 2
    peak_by_decay = -variance * (1 - decay * peak) / peak
    peak_by_variance = (peak**2 - variance + decay * variance * peak) / (2 * peak)
    height_by_variance = (decay * peak - variance / wide) / 2
    by_log_decay = decay * by_decay + along * peak_by_decay + raw * (decay * peak)
    by_log_variance = variance * by_variance + along * peak_by_variance + raw * height_by_variance
    return by_log_decay, by_log_variance, -along


def solve_powers(columns, line, scale):
    """Least-squares powers of the columns of a line, (column,).

    And the upper Cholesky factor of the normal matrix.
    """
    weighted = columns / scale
    normal = weighted @ weighted.T
    # Coincident layers cannot be separated: 1e-9 of the diagonal keeps the matrix invertible, far
    # below the noise.
    diagonal = np.einsum("ii->i", normal)  # a view
    diagonal *= 1 + 1e-9
    diagonal += 1e-300
    # SciPy's own checks cost as much as the solution.
    factor, powers, refused = dposv(normal, weighted @ (line.signal / scale))
    assert not refused, "the normal matrix is positive definite"
    return powers, factor


def rescale(line, model):
    """Scale of the next step's weights.

    It is the expected mean power, but never below the smoothed one.
    """
    line.scale = np.maximum(model + line.noise_power, line.smooth)


def _background_columns(rows, pick, surface):
    """Power of unpicked snow, no free shape, (column, row).

    By e-folding depth of its decline, then an echo a slab. Power from scatterers of density exp(-z
    / fall) is that exponential less the waveform's, ``exp(-rise z)``. It keeps a decline that
    continues below a layer's own decay from being taken for the layer's; so does an echo halfway
    between two picks with the power of crusts there. One is enough: many could stand for a slower
    decay.
    """
    depth = np.maximum(rows - surface, 0)
    declines = np.exp(-depth / BACKGROUND_FALLS[:, None]) - np.exp(-BACKGROUND_RISE * depth)
    slab = np.diff(pick)
    echo = (pick[:-1] + slab / 2)[slab >= ECHO_ROOM]
    echoes = waveform_exact(rows - echo[:, None], ECHO_VARIANCE, BACKGROUND_RISE)
    return np.concatenate([declines, echoes])
