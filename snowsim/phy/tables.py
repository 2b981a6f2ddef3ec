"""Eq. (1) for many layers at once: sub-bin tables where a layer is curved, an exponential where it has become one."""

import numba
import numpy as np

from snowsim.phy.supports import DEGREE
from snowsim.phy.waveform import waveform_unchecked

LINES_AT_A_TIME = 16  # one cache line of float32


@np.errstate(under="ignore")  # to zero, far below what counts
def tabulated_power(waveforms, supports, added_power):
    """Mean power of a scene by its supports, plus `added_power`.

    Parameters
    ----------
    waveforms : Waveforms
        The scene's layers.
    supports : Supports
        Where and how finely they are modelled.
    added_power : float
        Added to every pixel: the noise, or nothing.

    Returns
    -------
    ndarray of `supports.dtype`, (range_bin, range_line)
    """
    kept = np.flatnonzero(supports.kept)
    variance, decay = waveforms.variance_bins2[kept], waveforms.decay_rate[kept]
    first, tail, last = (edge[kept] for edge in (supports.first_bins, supports.tail_bins, supports.last_bins))
    n_phases = supports.n_phases[kept]
    # Powers near 1 keep float32 far from its limits.
    reference = max(waveforms.peak_power.max(initial=0), added_power) or 1.0
    amplitude = waveforms.amplitude[kept] / reference
    dtype = supports.dtype.type

    first_node = np.floor(first).astype(np.int64) - 1
    n_nodes = np.floor(tail).astype(np.int64) + 2 - first_node
    table_start = np.concatenate([[0], np.cumsum(n_phases * n_nodes)])
    layer = np.repeat(np.arange(kept.size), n_phases * n_nodes)
    phase, node = np.divmod(np.arange(table_start[-1]) - table_start[layer], n_nodes[layer])
    x_bins = first_node[layer] + node + phase / n_phases[layer]
    table = _taylor(x_bins, variance[layer], decay[layer], amplitude[layer], dtype)

    n_tail = np.clip(np.ceil(last - tail) + 1, 0, waveforms.n_range_bins).astype(np.int64)
    tail_start = np.concatenate([[0], np.cumsum(n_tail)])
    layer = np.repeat(np.arange(kept.size), n_tail)
    exponential = np.exp(-decay[layer] * (np.arange(tail_start[-1]) - tail_start[layer])).astype(dtype)
    log_tail = np.log(amplitude * np.sqrt(2 * np.pi * variance)) + decay**2 * variance / 2

    power = np.empty(waveforms.shape, dtype=dtype)
    _add_layers(
        waveforms.centre_bins if kept.size == supports.kept.size else waveforms.centre_bins[kept],
        np.stack([first, tail, last, decay, log_tail], axis=1),
        np.stack([n_phases, first_node, n_nodes, table_start[:-1], tail_start[:-1]], axis=1),
        table,
        exponential,
        dtype(added_power / reference),
        dtype(reference),
        power,
    )
    return power


def _taylor(x, variance, decay, amplitude, dtype):
    """Taylor coefficients of waveforms about x, (degree + 1, node), from ``w' = g - a w`` and ``g' = -(x / d) g``."""
    coefficients = np.empty((DEGREE + 1, x.size), dtype=dtype)
    gaussian_before, gaussian = 0.0, amplitude * np.exp(-x * x / (2 * variance))
    waveform = amplitude * waveform_unchecked(x, variance, decay)
    coefficients[0] = waveform
    for n in range(DEGREE):
        waveform = (gaussian - decay * waveform) / (n + 1)
        coefficients[n + 1] = waveform
        gaussian_before, gaussian = gaussian, -(x * gaussian + gaussian_before) / (variance * (n + 1))
    return coefficients


@numba.njit(cache=True, nogil=True, fastmath={"contract"})
def _add_layers(centre_bins, distances, indices, table, exponential, noise, reference, power):
    """Fill `power`, (range_bin, range_line), with reference * (noise + all layers)."""
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
                if not first <= last:  # outside the window, or NaN
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
                    _add_polynomials(column[int(first) : int(tail)], table, at, delta)
                n_tail = int(last + 1 - tail)
                if n_tail > 0:
                    scale = power.dtype.type(np.exp(distances[layer, 4] - distances[layer, 3] * (tail - centre)))
                    at = indices[layer, 4]
                    _add_scaled(column[int(tail) : int(last) + 1], exponential[at : at + n_tail], scale)
        for row in range(n_range_bins):
            for line in range(start, stop):
                power[row, line] = reference * lines[line - start, row]


@numba.njit(cache=True, nogil=True, fastmath={"contract"})
def _add_polynomials(column, table, at, delta):
    """Add degree-5 polynomials in `delta`, one per row, from the nodes `at` onwards."""
    stop = at + column.size
    c0, c1, c2 = table[0, at:stop], table[1, at:stop], table[2, at:stop]
    c3, c4, c5 = table[3, at:stop], table[4, at:stop], table[5, at:stop]
    for row in range(column.size):
        column[row] += c0[row] + delta * (
            c1[row] + delta * (c2[row] + delta * (c3[row] + delta * (c4[row] + delta * c5[row])))
        )


@numba.njit(cache=True, nogil=True, fastmath={"contract"})
def _add_scaled(column, exponential, scale):
    """Add an exponential, scaled."""
    for row in range(column.size):
        column[row] += scale * exponential[row]
