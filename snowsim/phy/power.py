"""Mean power of a scene by eq. (1), from a sub-bin table of each waveform or in closed form."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from snowsim.compiling import compiled
from snowsim.echogram import Echoes, Kind, check_layer_bins
from snowsim.limits import check_count, check_unmasked, check_values
from snowsim.phy.waveform import SAFE_RANGE, waveform_exact, waveform_peak

# Tables are accurate within these limits; outside them PHY takes the closed form. Unpicked snow
# that decays over 1000 bins lies within.
TABLE_RANGE = {"variance_bins2": (0.1, 100.0), "decay_rate": (1e-4, 1.0)}
LIMITS = SAFE_RANGE | {"peak_power": (0,)}
# Limits of the power of the strongest echo: within them float32 holds every echo that matters.
TABLE_POWERS = (1e-20, 1e20)
NODES_PER_BIN = 8
# A table starts `RISE_DEVIATIONS` above the centre, at 1e-12 of the waveform's peak. It ends
# `FALL_DEVIATIONS` below ``alpha d``, where the waveform is an exponential to 3e-5.
RISE_DEVIATIONS = 7.5
FALL_DEVIATIONS = 4.0
TAIL_DECAYS = 30  # length of the exponential in e-folding depths, down to 1e-13
WEAKEST = 1e-20  # relative to the strongest echo; weaker ones are left out
LINES_AT_A_TIME = 16  # one cache line of float32


@dataclass(frozen=True)
class Waveforms:
    """One scene's layers as the terms of eq. (1), ``P_s = sum_l amplitude_l w_l(x - centre_l)``.

    `centre_bins` (layer, range_line) is the centre of the Gaussian, NaN where the layer is absent;
    `amplitude` (layer, range_line) is the factor of the waveform [power per bin], 0 where absent.
    `variance_bins2`, `decay_rate` [per bin] and `unit_peak`, the largest value of the waveform of
    amplitude 1, have one value a layer. `n_range_bins` is the height of the window.
    """

    centre_bins: np.ndarray
    amplitude: np.ndarray
    variance_bins2: np.ndarray
    decay_rate: np.ndarray
    unit_peak: np.ndarray
    n_range_bins: int

    @property
    def shape(self):
        """(range_bin, range_line) of the window."""
        return self.n_range_bins, self.centre_bins.shape[1]


def mean_power(
    layer_bins: ArrayLike,
    peak_power: ArrayLike,
    variance_bins2: ArrayLike,
    decay_rate: ArrayLike,
    n_range_bins: int,
    *,
    exact: bool = False,
    as_printed: bool = False,
) -> NDArray[np.floating]:
    """Mean power of layered snow, without noise.

    Neglected: correlation between layers, off-nadir energy other than in the decay, surface
    roughness.

    Parameters
    ----------
    layer_bins : array_like, (layer, range_line)
        Fractional range bins, increasing with depth; NaN where absent. Tails of layers outside the
        window count, too.
    peak_power : array_like, (layer,) or (layer, range_line)
        Linear power, not negative; along track it may be NaN only where the layer is absent.
    variance_bins2 : array_like, (layer,)
        Variance of each layer's Gaussian [bins^2].
    decay_rate : array_like, (layer,)
        Rate of each layer's exponential [per bin].
    n_range_bins : int
        Height of the window.
    exact : bool, optional
        Take the closed form on every pixel, with a relative error of 1e-12. By default tables are
        used; with noise of at least 1e-8 of the scene's largest power added, they are within 0.05
        dB of the closed form.
    as_printed : bool, optional
        Take eq. (1) as it is printed: the Gaussian, not the waveform, has its peak on the layer,
        and `peak_power` is its height before the convolution.

    Returns
    -------
    ndarray of float64, (range_bin, range_line)

    Raises
    ------
    ValueError
        If a power is negative or not finite, a variance or rate not positive, a shape wrong, layers
        cross.

    Notes
    -----
    ``P_s(x) = sum_l m_l exp(-(x - mu_l)^2 / 2 d_l) (*) u(x) exp(-alpha_l x)``, convolved
    continuously in bins: Yari et al. (2021), IEEE JSTARS 14, eq. (1). The closed form is also
    taken, unasked, for scenes with a variance outside 0.1 to 100 bins^2, a rate outside 1e-4 to 1 a
    bin, or the strongest layer outside the window.

    Examples
    --------
    >>> layer_bins = np.array([[50.0, 50.0], [70.0, 72.0]])
    >>> scene = layer_bins, [1.0, 0.1], [2.0, 2.0], [0.3, 0.1], 120
    >>> exact = mean_power(*scene, exact=True)
    >>> exact.shape
    (120, 2)
    >>> exact[50].round(3)  # the waveform of the surface peaks at 1
    array([1., 1.])
    >>> bool(np.abs(10 * np.log10((mean_power(*scene) + 1e-8) / (exact + 1e-8))).max() < 0.05)
    True
    """
    echoes = echoes_of_parameters(layer_bins, peak_power, variance_bins2, decay_rate)
    return mean_power_of(echoes, n_range_bins, exact=exact, as_printed=as_printed)


def mean_power_of(echoes, n_range_bins, *, exact=False, as_printed=False):
    """Mean power of `Echoes` without noise, float64 (range_bin, range_line), as `mean_power`."""
    waveforms = checked_waveforms(echoes, n_range_bins, as_printed=as_printed)
    return power_of(waveforms, exact=exact).astype(float, copy=False)


def echoes_of_parameters(layer_bins, peak_power, variance_bins2, decay_rate, **radar):
    """`Echoes` of layers, not checked; without noise and of one look unless `radar` says more."""
    radar = {"noise_power": 0.0, "n_looks": 1.0} | radar
    kind = np.full(np.shape(layer_bins)[:1], Kind.LAYER, dtype=np.int8)
    return Echoes(layer_bins, peak_power, variance_bins2, decay_rate, kind, **radar)


def checked_waveforms(echoes, n_range_bins, *, as_printed=False):
    """`Waveforms` of `Echoes`, whose power may be (row,) where it is the same along track.

    ValueError with name, value and position for values of wrong shape or sign and echoes that
    cross.
    """
    for name in ("bins", "power", "variance_bins2", "decay_rate"):
        check_unmasked(f"{name} of layers", getattr(echoes, name))
    bins = np.asarray(echoes.bins, dtype=float)
    check_layer_bins(bins)
    check_count("n_range_bins", n_range_bins)
    variance = np.asarray(echoes.variance_bins2, dtype=float)
    decay = np.asarray(echoes.decay_rate, dtype=float)
    power = np.asarray(echoes.power, dtype=float)
    is_along_track = power.shape == bins.shape
    if is_along_track:
        power = np.where(np.isfinite(bins), power, 0)
    given = {"peak_power": power, "variance_bins2": variance, "decay_rate": decay}
    for name, values in given.items():
        may_vary = name == "peak_power" and is_along_track
        if values.shape != bins.shape[:1] and not may_vary:
            msg = f"{name}: expected one value for each of {len(bins)} layers, "
            msg += f"got shape {values.shape}"
            raise ValueError(msg)
        check_values(name, values, *LIMITS[name])
    power = power if is_along_track else power[:, None]
    offset_bins, unit_peak = waveform_peak(variance, decay)
    amplitude = power if as_printed else power / unit_peak[:, None]
    return Waveforms(
        centre_bins=bins if as_printed else bins - offset_bins[:, None],
        amplitude=np.where(np.isfinite(bins), amplitude, 0),
        variance_bins2=variance,
        decay_rate=decay,
        unit_peak=unit_peak,
        n_range_bins=int(n_range_bins),
    )


def power_of(waveforms, *, exact=False):
    """Mean power, (range_bin, range_line): float32 by tables, float64 by the closed form."""
    if exact or not tables_hold(waveforms):
        return exact_power(waveforms)
    return table_power(waveforms)


def tables_hold(waveforms):
    """True if tables are as close to the closed form as `mean_power` promises."""
    for name, (low, high) in TABLE_RANGE.items():
        values = getattr(waveforms, name)
        if not np.all((values >= low) & (values <= high)):
            return False
    # Tables leave out echoes far weaker than the strongest, so that one must lie in the window.
    peak_power = waveforms.amplitude * waveforms.unit_peak[:, None]
    centre = waveforms.centre_bins
    in_window = (centre >= 0) & (centre <= waveforms.n_range_bins - 1)
    strongest = peak_power.max(initial=0)
    low, high = TABLE_POWERS
    return low < strongest < high and strongest == peak_power.max(initial=0, where=in_window)


@np.errstate(under="ignore")
def exact_power(waveforms):
    """Mean power by the closed form on every pixel, float64 (range_bin, range_line)."""
    power = np.zeros(waveforms.shape)
    rows = np.arange(waveforms.n_range_bins)[:, None]
    for layer, lines in enumerate(np.isfinite(waveforms.centre_bins)):
        x_bins = rows - waveforms.centre_bins[layer, lines]
        one = waveform_exact(x_bins, waveforms.variance_bins2[layer], waveforms.decay_rate[layer])
        power[:, lines] += waveforms.amplitude[layer, lines] * one
    return power


class Tables(NamedTuple):
    """Tables of the waveforms of a scene's layers, of amplitude 1, and of their tails."""

    start: int  # first bin of all tables, from the centre of the waveform
    value: np.ndarray  # of each waveform, float32 (layer, sub-bin position, bin)
    slope: np.ndarray  # of its logarithm [per bin], as `value`
    rise: np.ndarray  # where a layer's table starts, (layer,) [bins below the centre]
    fall: np.ndarray  # where it ends and the tail begins, (layer,) [bins below the centre]
    variance: np.ndarray  # (layer,) [bins^2]
    decay: np.ndarray  # (layer,) [per bin]
    log_tail: np.ndarray  # logarithm of the tail, extended to the centre, (layer,)
    exponential: np.ndarray  # fall of the tail from bin to bin, float32 (layer, bin)


# Tables of narrow layers underflow in bins that are never read.
@np.errstate(under="ignore", divide="ignore", invalid="ignore")
def table_power(waveforms, nodes_per_bin=NODES_PER_BIN):
    """Mean power by a table of each layer's waveform, float32 (range_bin, range_line).

    About the nearest node ``log w`` is approximated by a parabola: it has the value and slope at
    the node, and half the Gaussian's curvature, ``-1 / 2d``. The true curvature lies between
    ``-1 / d`` far above the peak and 0 far below, so with h bins from node to node the relative
    error is at most ``h^2 / 16 d``. Below its table a waveform is ``sqrt(2 pi d) exp(alpha^2 d / 2
    - alpha x)``.
    """
    largest = (waveforms.amplitude * waveforms.unit_peak[:, None]).max()
    share = waveforms.amplitude / largest
    power = np.empty(waveforms.shape, dtype=np.float32)
    tables = _tables_of(waveforms, nodes_per_bin)
    _add_layers(waveforms.centre_bins, share, tables, np.float32(largest), power)
    return power


def _tables_of(waveforms, nodes_per_bin):
    """`Tables` of waveforms, with so many sub-bin positions."""
    variance = waveforms.variance_bins2[:, None]
    decay = waveforms.decay_rate[:, None]
    deviation = np.sqrt(variance)
    fall = decay * variance + FALL_DEVIATIONS * deviation
    start = int(np.floor(-RISE_DEVIATIONS * deviation.max()))
    n_bins = int(np.ceil(fall.max())) - start + 2
    # Nodes are sorted by sub-bin position, then bin: neighbouring range bins read neighbours.
    phase = np.arange(nodes_per_bin)[:, None] / nodes_per_bin
    x_bins = (start + phase + np.arange(n_bins)).ravel()
    value = waveform_exact(x_bins, variance, decay)
    slope = np.exp(-(x_bins**2) / (2 * variance)) / value - decay  # w' = exp(-x^2 / 2d) - a w
    n_tail = int(min(np.ceil(TAIL_DECAYS / decay.min()), waveforms.n_range_bins))
    by_phase = (len(decay), nodes_per_bin, n_bins)
    return Tables(
        start=start,
        value=value.astype(np.float32).reshape(by_phase),
        slope=slope.astype(np.float32).reshape(by_phase),
        rise=-RISE_DEVIATIONS * deviation[:, 0],
        fall=fall[:, 0],
        variance=waveforms.variance_bins2,
        decay=waveforms.decay_rate,
        log_tail=(np.log(np.sqrt(2 * np.pi * variance)) + decay**2 * variance / 2)[:, 0],
        exponential=np.exp(-decay * np.arange(n_tail)).astype(np.float32),
    )


@compiled(nogil=True, fastmath={"contract"})
def _add_layers(centre_bins, share, tables, unit, power):
    """Fill `power` (range_bin, range_line) with the sum of all layers.

    A layer has the amplitude `share` (layer, range_line) times `unit`.
    """
    n_range_bins, n_lines = power.shape
    n_nodes = tables.value.shape[1]
    lines = np.empty((LINES_AT_A_TIME, n_range_bins), dtype=np.float32)
    for at in range(0, n_lines, LINES_AT_A_TIME):
        stop = min(at + LINES_AT_A_TIME, n_lines)
        for line in range(at, stop):
            column = lines[line - at]
            column[:] = 0
            for layer in range(len(tables.decay)):
                centre = centre_bins[layer, line]
                scale = share[layer, line]
                first = max(np.ceil(centre + tables.rise[layer]), 0.0)
                if not first < n_range_bins or scale < WEAKEST:  # below the window, or NaN
                    continue
                table_end = np.ceil(centre + tables.fall[layer])
                tail_row = min(max(table_end, first), float(n_range_bins))
                if tail_row > first:
                    place = (first - centre - tables.start) * n_nodes
                    nearest = int(np.floor(place + 0.5))
                    away = (place - nearest) / n_nodes
                    node = nearest // n_nodes
                    phase = nearest - node * n_nodes
                    _add_head(
                        column[int(first) : int(tail_row)],
                        tables.value[layer, phase, node:],
                        tables.slope[layer, phase, node:],
                        np.float32(away),
                        np.float32(scale * np.exp(-(away**2) / (4 * tables.variance[layer]))),
                    )
                last = min(tail_row + tables.exponential.shape[1], float(n_range_bins))
                if last > tail_row:
                    decayed = tables.decay[layer] * (tail_row - centre)
                    scale *= np.exp(tables.log_tail[layer] - decayed)
                    _add_tail(
                        column[int(tail_row) : int(last)],
                        tables.exponential[layer],
                        np.float32(scale),
                    )
        for row in range(n_range_bins):
            for line in range(at, stop):
                power[row, line] = unit * lines[line - at, row]


@compiled(nogil=True, fastmath={"contract"})
def _add_head(column, value, slope, away, scale):
    """Add a waveform, read `away` bins from the nodes of its table.

    The exponential is a series of degree 6, whose error is 7e-4 where its argument is 1.2.
    """
    for row in range(column.size):
        y = away * slope[row]
        series = np.float32(1 / 120) + y * np.float32(1 / 720)
        series = np.float32(1 / 24) + y * series
        series = np.float32(1 / 6) + y * series
        series = np.float32(1 / 2) + y * series
        series = np.float32(1) + y * series
        series = np.float32(1) + y * series
        column[row] += scale * value[row] * series


@compiled(nogil=True, fastmath={"contract"})
def _add_tail(column, exponential, scale):
    """Add `scale` times an exponential."""
    for row in range(column.size):
        column[row] += scale * exponential[row]
