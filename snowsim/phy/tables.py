"""Eq. (1) for many layers at once: sub-bin tables about the peaks, plain exponentials in the tails.

Where each layer is modelled, and how finely, follows from the relative error that is allowed.
"""

from dataclasses import dataclass

import numba
import numpy as np
from scipy.special import erfcinv, erfcx

from snowsim.phy.waveform import waveform_exact

DEGREE = 5  # of the Taylor polynomials about the nodes of a sub-bin table

# How the relative error of P_s + P_n is shared out; the last eighth is for rounding.
SHARE_TRUNCATION = 1 / 2
SHARE_TABLE = 1 / 4
SHARE_TAIL = 1 / 8
SHARE_ROUNDING = 1 / 8
# Far from underflow, products included.
SMALLEST_RELATIVE_NOISE = {np.float32: 1e-20, np.float64: 1e-200}
FLOAT32_RANGE = (1e-20, 1e20)
LARGEST_ERROR = 0.5  # looser tolerances gain nothing
MOST_PHASES = 4096
# Taylor coefficients are differences that lose (a h / 2)^5 / 120 units in the last place: 9e3 at
# this product.
LARGEST_DECAY_STEP = 32
TABLE_ROUNDING = 1e-11
LINES_AT_A_TIME = 16  # one cache line of float32


def allowed_error(tolerance_db):
    """Largest relative error of power within a tolerance [dB], at most `LARGEST_ERROR`."""
    return min(1 - 10 ** (-tolerance_db / 10), LARGEST_ERROR)


@dataclass(frozen=True)
class Supports:
    """Where and how each layer is modelled, arrays (layer,).

    Distances are in bins below the layer's Gaussian centre. Layers that are `kept` are read from a
    sub-bin table of `n_phases` nodes per bin between `first_bins` and `tail_bins`, are a plain
    exponential from there to `last_bins`, and are left out elsewhere. `dtype` is that of tables and
    sums. No pixel's ``P_s + P_n`` is off by more than the share `error`.
    """

    kept: np.ndarray
    first_bins: np.ndarray
    tail_bins: np.ndarray
    last_bins: np.ndarray
    n_phases: np.ndarray
    dtype: np.dtype
    error: float

    def n_nodes(self):
        """Number of table nodes to evaluate."""
        length = np.where(self.kept, self.tail_bins - self.first_bins + 4, 0)
        return int((self.n_phases * length).sum())

    def n_rows(self, centre_bins, n_range_bins):
        """Pixels times layers within the supports, from tables and as exponentials: two int."""

        def rows_above(edge):
            row = np.ceil(centre_bins[self.kept] + edge[self.kept, None])
            # fmin turns NaN into the bottom row of every edge: absent layers count as zero.
            return np.fmax(np.fmin(row, n_range_bins), 0).sum()

        first = rows_above(self.first_bins)
        tail = rows_above(self.tail_bins)
        last = rows_above(self.last_bins)
        return int(tail - first), int(last - tail)


@np.errstate(under="ignore")
def find_supports(waveforms, noise_power, error):
    """Smallest supports and coarsest tables that keep ``|P - P_s| <= error (P_s + P_n)``.

    At every pixel. `noise_power` is P_n, positive; `error` lies in (0, 0.5]. Returns `Supports`, or
    None where only the closed form is safe: noise or tolerance too close to the resolution of
    float64.

    Notes
    -----
    With ``w`` of variance d and rate a, its peak at x >= 0, L layers and ``b = error P_n / 2L``:

    - Truncation. ``w(x) <= w(0) exp(-x^2 / 2d)`` for x <= 0, ``w(x) <= sqrt(pi d / 2) exp(-x^2 /
      2d)`` for x <= a d, and ``w(x) <= sqrt(2 pi d) exp(a^2 d / 2 - a x)`` everywhere. The support
      ends where these fall below b; a pixel lies beyond at most one end of each layer, so all
      layers together leave out at most ``error P_n / 2``.
    - Tail. ``w`` is that last exponential times ``1 - erfc(-z) / 2``, z = (a d - x) / sqrt(2 d).
    - Table. Taylor polynomials of degree p = 5 about nodes h apart. Cauchy's estimate on a circle
      of radius R bounds the remainder by ``max |w| r^(p+1) / (1 - r)``, r = h / 2R. There ``|w(x +
      u + iv)| <= w(x + u) exp(v^2 / 2d)``, because it holds for the Gaussian, and ``w(x + u) <=
      w(x) exp(|u s(x)|)``, because log w is concave with slope s. ``-1/d <= s' <= 0`` and ``s(x) >=
      -min(a, x / d)``. On the rising edge s has no useful bound, but left of where w crosses P_n /
      L the noise hides the layer: there ``w exp(k s)`` falls with -x as long as s > k / d. So with
      k = R + h / 2 and S the largest of k / d, s at that crossing, and the trailing bound, the
      remainder is below ``exp(R^2 / 2d + R h / 2d + k S) r^(p+1) / (1 - r)`` of ``w + P_n / L``.
    - Powers that vary along track. Everything is worked out for a layer's largest power. Times a
      share s of 0 to 1 what is left out only shrinks, and an error of ``e (w + P_n / L)`` stays
      below ``e (s w + P_n / L)``.
    """
    n_layers = max(waveforms.amplitude.size, 1)
    reference = max(waveforms.peak_power.max(initial=0), noise_power)
    dtype = _dtype(n_layers, noise_power, reference, error)
    if dtype is None:
        return None
    variance, decay = waveforms.variance_bins2, waveforms.decay_rate
    deviation = np.sqrt(variance)
    edge = SHARE_TRUNCATION * error * noise_power / n_layers
    kept = waveforms.peak_power > edge

    def reach(power, level):
        """Distance at which a Gaussian of this largest power has fallen to a level."""
        log_ratio = log_amplitude + np.log(power / level)
        return deviation * np.sqrt(2 * np.maximum(log_ratio, 0))

    area = np.sqrt(np.pi / 2) * deviation  # of half the Gaussian
    at_centre = area * erfcx(decay * deviation / np.sqrt(2))
    log_amplitude = np.log(np.where(kept, waveforms.amplitude, 1))
    first = -reach(at_centre, edge)
    gaussian_end = reach(area, edge)
    log_exponential = log_amplitude + np.log(2 * area / edge)
    exponential_end = log_exponential / decay + decay * variance / 2
    # The Gaussian bounds the trailing side only if that side, from peak to end, lies at x <= a d.
    gaussian_holds = np.maximum(gaussian_end, waveforms.peak_offset_bins) <= decay * variance
    last = np.where(gaussian_holds, gaussian_end, exponential_end)
    last = np.maximum(last, waveforms.peak_offset_bins)
    clearance = erfcinv(2 * SHARE_TAIL * error * (1 - error))
    tail = np.minimum(decay * variance + np.sqrt(2) * deviation * clearance, last)

    crossing = -reach(at_centre * n_layers, noise_power)
    slope = np.maximum(_slope(crossing, variance, decay), np.minimum(decay, tail / variance))
    n_phases, table_error = _coarsest_table(variance, decay, slope, SHARE_TABLE * error, kept)
    if table_error > SHARE_TABLE * error:
        return None
    total = SHARE_TRUNCATION * error + table_error + SHARE_TAIL * error
    total += _rounding(n_layers, dtype)
    return Supports(kept, first, tail, last, n_phases, np.dtype(dtype), float(total))


def _slope(x, variance, decay):
    """Slope of log w."""
    deviation = np.sqrt(variance)
    z = (decay * variance - x) / (np.sqrt(2) * deviation)
    return np.sqrt(2 / np.pi) / (deviation * erfcx(z)) - decay


def _coarsest_table(variance, decay, slope, error, kept):
    """Nodes per bin, a power of two for each layer, and the largest remainder of the kept ones."""
    order = DEGREE + 1
    # Minimises exp(R^2 / 2d + R S) / R^order.
    radius = variance / 2 * (np.sqrt(slope**2 + 4 * order / variance) - slope)
    spread = radius**2 / (2 * variance)
    wanted = np.log(error) - spread - radius * slope
    enough_for_error = np.log2(1 / (2 * radius)) - wanted / order / np.log(2)
    enough_for_decay = np.log2(decay / LARGEST_DECAY_STEP)
    enough = np.maximum(enough_for_error, enough_for_decay)
    n_phases = 2 ** np.ceil(np.clip(enough, 0, np.log2(MOST_PHASES)))
    while True:
        step = 1 / n_phases
        ratio = step / (2 * radius)
        reach = radius + step / 2
        steepest = np.maximum(slope, reach / variance)
        exponent = radius * reach / variance - spread + reach * steepest
        # Refused rather than overflowing: far more phases are needed, or more than are allowed.
        usable = (ratio < 1) & (exponent < 100) & (decay <= LARGEST_DECAY_STEP * n_phases)
        remainder = np.full(variance.shape, np.inf)
        bound = np.exp(exponent[usable]) * ratio[usable] ** order
        remainder[usable] = bound / (1 - ratio[usable])
        short = kept & (remainder > error) & (n_phases < MOST_PHASES)
        if not short.any():
            return n_phases.astype(np.int64), float(remainder[kept].max(initial=0))
        n_phases[short] *= 2


def _rounding(n_layers, dtype):
    """Relative error of adding layers, each from 6 products and 3 factors.

    Terms of a table may add up to e^2 of it.
    """
    return (n_layers + 24) * float(np.finfo(dtype).eps) + TABLE_ROUNDING


def _dtype(n_layers, noise_power, reference, error):
    """Shortest float type whose rounding and range do not affect the error, or None."""
    smallest_power, largest_power = FLOAT32_RANGE
    for dtype, smallest in SMALLEST_RELATIVE_NOISE.items():
        in_range = dtype is np.float64 or smallest_power < reference < largest_power
        precise = _rounding(n_layers, dtype) <= SHARE_ROUNDING * error
        if in_range and precise and noise_power > smallest * reference:
            return dtype
    return None


@np.errstate(under="ignore")  # to zero, far below what counts
def tabulated_power(waveforms, supports, added_power):
    """Mean power of a scene by its supports plus `added_power`, (range_bin, range_line)."""
    kept = np.flatnonzero(supports.kept)
    variance = waveforms.variance_bins2[kept]
    decay = waveforms.decay_rate[kept]
    first = supports.first_bins[kept]
    tail = supports.tail_bins[kept]
    last = supports.last_bins[kept]
    n_phases = supports.n_phases[kept]
    # Powers near 1 keep float32 far from its limits.
    reference = max(waveforms.peak_power.max(initial=0), added_power) or 1.0
    amplitude = waveforms.amplitude[kept] / reference
    dtype = supports.dtype.type

    first_node = np.floor(first).astype(np.int64) - 1
    n_nodes = np.floor(tail).astype(np.int64) + 2 - first_node
    layer, table_start, place = _in_a_row(n_phases * n_nodes)
    phase, node = np.divmod(place, n_nodes[layer])
    x_bins = first_node[layer] + node + phase / n_phases[layer]
    table = _taylor(x_bins, variance[layer], decay[layer], amplitude[layer], dtype)

    n_tail = np.clip(np.ceil(last - tail) + 1, 0, waveforms.n_range_bins).astype(np.int64)
    layer, tail_start, place = _in_a_row(n_tail)
    exponential = np.exp(-decay[layer] * place).astype(dtype)
    log_tail = np.log(amplitude * np.sqrt(2 * np.pi * variance)) + decay**2 * variance / 2

    power = np.empty(waveforms.shape, dtype=dtype)
    shares = np.ones((kept.size, 1), dtype=dtype)
    if waveforms.line_share is not None:
        shares = waveforms.line_share[kept].astype(dtype)
    _add_layers(
        waveforms.centre_bins[kept],
        shares,
        np.stack([first, tail, last, decay, log_tail], axis=1),
        np.stack([n_phases, first_node, n_nodes, table_start, tail_start], axis=1),
        table,
        exponential,
        dtype(added_power / reference),
        dtype(reference),
        power,
    )
    return power


def _in_a_row(counts):
    """Layers' elements one layer after the other: layer of each, starts by layer, place in it."""
    start = np.cumsum(counts) - counts
    layer = np.repeat(np.arange(counts.size), counts)
    return layer, start, np.arange(layer.size) - start[layer]


def _taylor(x, variance, decay, amplitude, dtype):
    """Taylor coefficients of waveforms about x, (degree + 1, node).

    From ``w' = g - a w`` and ``g' = -(x / d) g``.
    """
    coefficients = np.empty((DEGREE + 1, x.size), dtype=dtype)
    gaussian = amplitude * np.exp(-x * x / (2 * variance))
    gaussian_before = 0.0
    waveform = amplitude * waveform_exact(x, variance, decay)
    coefficients[0] = waveform
    for n in range(DEGREE):
        waveform = (gaussian - decay * waveform) / (n + 1)
        coefficients[n + 1] = waveform
        gaussian_after = -(x * gaussian + gaussian_before) / (variance * (n + 1))
        gaussian_before = gaussian
        gaussian = gaussian_after
    return coefficients


@numba.njit(cache=True, nogil=True, fastmath={"contract"})
def _add_layers(
    centre_bins, shares, distances, indices, table, exponential, noise, reference, power
):
    """Fill `power`, (range_bin, range_line), with reference * (noise + all layers).

    `shares` is (layer, 1 or line).
    """
    n_range_bins, n_lines = power.shape
    lines = np.empty((LINES_AT_A_TIME, n_range_bins), dtype=power.dtype)
    for start in range(0, n_lines, LINES_AT_A_TIME):
        stop = min(start + LINES_AT_A_TIME, n_lines)
        for line in range(start, stop):
            column = lines[line - start]
            column[:] = noise
            for layer in range(centre_bins.shape[0]):
                centre = centre_bins[layer, line]
                first = max(np.ceil(centre + distances[layer, 0]), 0.0)
                last = min(np.floor(centre + distances[layer, 2]), n_range_bins - 1.0)
                share = shares[layer, line if shares.shape[1] > 1 else 0]
                if not first <= last or share == 0:  # outside the window, or NaN
                    continue
                tail = min(max(np.ceil(centre + distances[layer, 1]), first), last + 1)
                n_head = int(tail - first)
                if n_head > 0:
                    n_phases = indices[layer, 0]
                    nearest = np.floor((first - centre) * n_phases + 0.5)
                    delta = power.dtype.type(first - centre - nearest / n_phases)
                    node = int(np.floor(nearest / n_phases))
                    phase = int(nearest) - node * n_phases
                    at = indices[layer, 3] + phase * indices[layer, 2] + node - indices[layer, 1]
                    _add_polynomials(column[int(first) : int(tail)], table, at, delta, share)
                n_tail = int(last + 1 - tail)
                if n_tail > 0:
                    log_scale = distances[layer, 4] - distances[layer, 3] * (tail - centre)
                    scale = power.dtype.type(np.exp(log_scale))
                    scale *= share
                    fall = exponential[indices[layer, 4] :][:n_tail]
                    _add_scaled(column[int(tail) : int(last) + 1], fall, scale)
        for row in range(n_range_bins):
            for line in range(start, stop):
                power[row, line] = reference * lines[line - start, row]


@numba.njit(cache=True, nogil=True, fastmath={"contract"})
def _add_polynomials(column, table, at, delta, share):
    """Add degree-5 polynomials in `delta`, one per row, from nodes `at` onwards, times `share`."""
    stop = at + column.size
    c0 = table[0, at:stop]
    c1 = table[1, at:stop]
    c2 = table[2, at:stop]
    c3 = table[3, at:stop]
    c4 = table[4, at:stop]
    c5 = table[5, at:stop]
    for row in range(column.size):
        value = c4[row] + delta * c5[row]
        value = c3[row] + delta * value
        value = c2[row] + delta * value
        value = c1[row] + delta * value
        value = c0[row] + delta * value
        column[row] += share * value


@numba.njit(cache=True, nogil=True, fastmath={"contract"})
def _add_scaled(column, exponential, scale):
    """Add an exponential, scaled."""
    for row in range(column.size):
        column[row] += scale * exponential[row]
