"""Slow, other and failing ways to the same scene, kept to be compared with: no renderer uses them."""

from dataclasses import replace

import numba
import numpy as np
from scipy.signal import fftconvolve
from scipy.special import erfc

from snowsim.phy.parameters import checked_power, checked_waveforms
from snowsim.phy.plan import plan_power
from snowsim.phy.power import exact_power, planned_power
from snowsim.phy.speckle import checked_looks, draw_gamma, draw_looks, draw_speckle
from snowsim.phy.tables import allowed_error, find_supports, tabulated_power
from snowsim.phy.waveform import waveform_unchecked

CUT_DEVIATIONS, CUT_BINS = 5, 150  # the support that is often assumed


def waveforms_of(layer_bins, parameters, n_range_bins, normalise, align):
    """`Waveforms` of layers and parameters as `render` is given them."""
    shapes = (parameters[name] for name in ("peak_power", "variance_bins2", "decay_rate"))
    return checked_waveforms(layer_bins, *shapes, n_range_bins, normalise, align)


def render_as_printed(layer_bins, parameters, n_range_bins, *, rng, normalise="peak", align="peak"):
    """What `render` gives, as printed: whole columns convolved, then M looks of 4 normals for every pixel, float64.

    Yari et al. (2021), eqs (1), (3), (4): ``P = 1/M sum |sqrt(P_s / 2) (n1 + i n2) + sqrt(P_n / 2)
    (n3 + i n4)|^2``.
    """
    waveforms = waveforms_of(layer_bins, parameters, n_range_bins, normalise, align)
    n_looks = int(checked_looks(parameters["n_looks"]))
    signal = np.sqrt(convolved_power(waveforms) / 2)
    noise = np.sqrt(checked_power("noise_power", parameters["noise_power"]) / 2)
    total = np.zeros(waveforms.shape)
    for _ in range(n_looks):
        normals = rng.standard_normal((4, *waveforms.shape))
        total += (signal * normals[0] + noise * normals[2]) ** 2 + (
            signal * normals[1] + noise * normals[3]
        ) ** 2
    return total / n_looks


def render_scatterers(
    layer_bins, parameters, n_range_bins, *, rng, n_scatterers=100, align="gaussian"
):
    """What `render` gives, as a sum of point scatterers, in the manner of the CReSIS toolbox's simulator.

    Those of a layer and range line are normal about it plus an exponential delay, with exponential
    power and sinc-squared responses on every row. They are its only speckle: `n_looks` acts on the
    noise.
    """
    waveforms = waveforms_of(layer_bins, parameters, n_range_bins, "peak", align)
    n_looks = checked_looks(parameters["n_looks"])
    noise = np.full(waveforms.shape, checked_power("noise_power", parameters["noise_power"]))
    power = draw_speckle(noise, n_looks, method="gamma", rng=rng)
    rows = np.arange(n_range_bins)[:, None]
    deviation = np.sqrt(waveforms.variance_bins2)
    # A waveform holds sqrt(2 pi d) / a in all, a response one bin.
    energy = waveforms.amplitude * np.sqrt(2 * np.pi) * deviation / waveforms.decay_rate
    for layer, line in np.argwhere(np.isfinite(waveforms.centre_bins)):
        delay = deviation[layer] * rng.standard_normal(n_scatterers)
        delay += rng.exponential(1 / waveforms.decay_rate[layer], n_scatterers)
        strength = rng.exponential(energy[layer] / n_scatterers, n_scatterers)
        response = np.sinc(rows - waveforms.centre_bins[layer, line] - delay) ** 2
        power[:, line] += response @ strength
    return power


def draw_moving_speckle(mean_power, *, method, rng):
    """Power averaged over looks with means of their own, (look, range_bin, range_line): the geometry moves.

    ``looks``: sum of looks. ``gamma``: shape ``(sum m)^2 / sum m^2``, right in mean and variance,
    exact if all equal.
    """
    if method == "looks":
        return draw_looks(mean_power, rng)
    mean = mean_power.mean(axis=0)
    # Relative to the largest, so that squares neither overflow nor vanish.
    largest = np.maximum(mean_power.max(axis=0), np.finfo(mean_power.dtype).tiny)
    relative = mean_power / largest
    squares = np.maximum((relative**2).sum(axis=0), np.finfo(mean_power.dtype).tiny)
    shape = np.where(mean > 0, np.maximum(relative.sum(axis=0) ** 2 / squares, 1), len(mean_power))
    return draw_gamma(mean, shape.astype(mean.dtype), rng)


def convolved_power(waveforms, samples_per_bin=1):
    """Mean power by numerical convolution of whole columns, from above the topmost layer: nothing wraps around.

    Narrow Gaussians alias, fast decays are summed coarsely, the transform leaves 1e-16 of the peak
    everywhere.
    """
    topmost = np.nanmin(
        waveforms.centre_bins - 8 * np.sqrt(waveforms.variance_bins2)[:, None], initial=0
    )
    n_above = int(np.ceil(-topmost)) * samples_per_bin
    n_samples = (waveforms.n_range_bins - 1) * samples_per_bin + 1 + n_above
    x_bins = ((np.arange(n_samples) - n_above) / samples_per_bin)[:, None]
    delay = np.arange(n_samples) / samples_per_bin
    power = np.zeros((n_samples, waveforms.shape[1]))
    for layer, centre in enumerate(waveforms.centre_bins):
        lines = np.isfinite(centre)
        gaussian = np.exp(-((x_bins - centre[lines]) ** 2) / (2 * waveforms.variance_bins2[layer]))
        exponential = (
            np.exp(-waveforms.decay_rate[layer] * delay)
            * waveforms.amplitude[layer]
            / samples_per_bin
        )
        exponential[0] /= 2  # trapezoids: the exponential starts with a step
        power[:, lines] += fftconvolve(gaussian, exponential[:, None], axes=0)[:n_samples]
    return np.maximum(power[n_above::samples_per_bin], 0)


def waveform_naive(x_bins, variance_bins2, decay_rate):
    """The closed form as it is usually written: overflows for wide or fast-decaying waveforms, NaN in its head."""
    x_bins = np.asarray(x_bins, dtype=float)
    z = (decay_rate * variance_bins2 - x_bins) / np.sqrt(2 * variance_bins2)
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        growth = np.exp(decay_rate**2 * variance_bins2 / 2 - decay_rate * x_bins)
        return np.sqrt(np.pi * variance_bins2 / 2) * growth * erfc(z)


def table_power(waveforms, noise_power, tolerance_db):
    """Closed form by sub-bin tables within the supports of the tolerance, as `mean_power` has it."""
    return planned_power(plan_power(waveforms, noise_power, tolerance_db))


def single_precision_power(waveforms, noise_power, tolerance_db):
    """Sub-bin tables with tables and sums forced into float32; ValueError without supports."""
    supports = _found_supports(waveforms, noise_power, tolerance_db)
    return tabulated_power(waveforms, replace(supports, dtype=np.dtype(np.float32)), 0.0)


def power_in_support(waveforms, noise_power, tolerance_db):
    """Closed form on the rows of each layer's support only; ValueError without supports."""
    supports = _found_supports(waveforms, noise_power, tolerance_db)
    power = np.zeros(waveforms.shape)
    for layer in np.flatnonzero(supports.kept):
        lines = np.flatnonzero(np.isfinite(waveforms.centre_bins[layer]))
        centre = waveforms.centre_bins[layer, lines]
        first = np.clip(
            np.ceil(centre + supports.first_bins[layer]), 0, waveforms.n_range_bins
        ).astype(int)
        stop = np.clip(
            np.floor(centre + supports.last_bins[layer]) + 1, 0, waveforms.n_range_bins
        ).astype(int)
        rows = first + np.arange((stop - first).max(initial=0))[:, None]
        inside = rows < stop
        x_bins = (rows - centre)[inside]
        one = waveform_unchecked(
            x_bins, waveforms.variance_bins2[layer], waveforms.decay_rate[layer]
        )
        power[rows[inside], np.broadcast_to(lines, rows.shape)[inside]] += (
            waveforms.amplitude[layer] * one
        )
    return power


def recursive_power(waveforms, noise_power, tolerance_db, dtype=float):
    """A filter with a state of `dtype` within the supports, which does not keep the tolerance."""
    supports = _found_supports(waveforms, noise_power, tolerance_db)
    power = np.zeros(waveforms.shape, dtype=dtype)
    per_layer = (waveforms.amplitude, waveforms.variance_bins2, waveforms.decay_rate)
    ends = (
        np.where(supports.kept, edge, np.nan) for edge in (supports.first_bins, supports.last_bins)
    )
    _filter_layers(waveforms.centre_bins, *per_layer, *ends, power)
    return power


def _found_supports(waveforms, noise_power, tolerance_db):
    supports = find_supports(waveforms, noise_power, allowed_error(tolerance_db))
    if supports is None:
        msg = f"no support keeps {tolerance_db:g} dB with noise_power {noise_power:g}"
        raise ValueError(msg)
    return supports


@numba.njit(cache=True)
def _filter_layers(centre_bins, amplitude, variance, decay, first_bins, last_bins, power):
    """Add layers by recursion: Simpson's rule over one bin of Gaussian, itself stepped by ratios of ratios."""
    one = power.dtype.type(1)
    for layer in range(centre_bins.shape[0]):
        fade = power.dtype.type(np.exp(-decay[layer]))
        half_fade = power.dtype.type(4 * np.exp(-decay[layer] / 2))
        bend = power.dtype.type(np.exp(-0.25 / variance[layer]))
        for line in range(centre_bins.shape[1]):
            centre = centre_bins[layer, line]
            start = np.ceil(centre + first_bins[layer])
            stop = min(np.floor(centre + last_bins[layer]) + 1, power.shape[0])
            if not start < stop:
                continue
            x = start - centre
            gaussian = power.dtype.type(
                amplitude[layer] * np.exp(-x * x / (2 * variance[layer])) / 6
            )
            ratio = power.dtype.type(np.exp(-(x / 2 + 0.125) / variance[layer]))
            state = one * 0
            for row in range(int(start), int(stop)):
                if row >= 0:
                    power[row, line] += state
                between = gaussian * ratio
                ratio *= bend
                after = between * ratio
                ratio *= bend
                state = state * fade + gaussian * fade + between * half_fade + after
                gaussian = after


def naive_power(waveforms):
    """Closed form on every row as it is usually written."""
    return summed_power(waveforms, waveform_naive)


def cut_power(waveforms):
    """Closed form between 5 deviations above and 150 bins below each Gaussian's centre, whatever the decay."""

    def cut(x_bins, variance_bins2, decay_rate):
        inside = (x_bins >= -CUT_DEVIATIONS * np.sqrt(variance_bins2)) & (x_bins <= CUT_BINS)
        return np.where(inside, waveform_unchecked(x_bins, variance_bins2, decay_rate), 0)

    return summed_power(waveforms, cut)


def nearest_power(waveforms, n_phases=16):
    """Closed form with centres moved to the nearest of `n_phases` places a bin, as tables without interpolation do."""
    return exact_power(
        replace(waveforms, centre_bins=np.rint(waveforms.centre_bins * n_phases) / n_phases)
    )


def wrapped_power(waveforms):
    """Convolution of the window's columns by Fourier transforms of the window's height, without padding."""
    rows = np.arange(waveforms.n_range_bins)[:, None]

    def wrapped(x_bins, variance_bins2, decay_rate):
        gaussian = np.exp(-(x_bins**2) / (2 * variance_bins2))
        exponential = np.exp(-decay_rate * rows)
        exponential[0] /= 2
        spectrum = np.fft.rfft(gaussian, axis=0) * np.fft.rfft(exponential, axis=0)
        return np.fft.irfft(spectrum, len(rows), axis=0)

    return np.maximum(summed_power(waveforms, wrapped), 0)


def summed_power(waveforms, waveform, rows=None):
    """Sum of all layers by ``waveform(x_bins, variance_bins2, decay_rate)``, float64, on every row or on some."""
    rows = np.arange(waveforms.n_range_bins) if rows is None else np.asarray(rows)
    power = np.zeros((len(rows), waveforms.shape[1]))
    for layer, lines in enumerate(np.isfinite(waveforms.centre_bins)):
        x_bins = rows[:, None] - waveforms.centre_bins[layer, lines]
        one = waveform(x_bins, waveforms.variance_bins2[layer], waveforms.decay_rate[layer])
        power[:, lines] += waveforms.amplitude[layer] * one
    return power
