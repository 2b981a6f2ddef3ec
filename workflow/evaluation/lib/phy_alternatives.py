"""Slow, other and failing ways to the same scene, to be compared with: no renderer uses them."""

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

# The support that is often assumed, above and below the Gaussian's centre.
CUT_DEVIATIONS = 5
CUT_BINS = 150


def waveforms_of(layer_bins, parameters, n_range_bins):
    """`Waveforms` of layers and parameters as `render` takes them, by its default conventions."""
    return checked_waveforms(
        layer_bins,
        parameters["peak_power"],
        parameters["variance_bins2"],
        parameters["decay_rate"],
        n_range_bins,
        normalise="peak",
        align="peak",
    )


def render_as_printed(layer_bins, parameters, n_range_bins, *, rng):
    """What `render` gives, as printed: columns convolved, M looks of 4 normals for every pixel.

    Yari et al. (2021), eqs (1), (3), (4): ``P = 1/M sum |sqrt(P_s / 2) (n1 + i n2) + sqrt(P_n / 2)
    (n3 + i n4)|^2``.
    """
    waveforms = waveforms_of(layer_bins, parameters, n_range_bins)
    n_looks = int(checked_looks(parameters["n_looks"]))
    signal = np.sqrt(convolved_power(waveforms) / 2)
    noise = np.sqrt(checked_power("noise_power", parameters["noise_power"]) / 2)
    total = np.zeros(waveforms.shape)
    for _ in range(n_looks):
        n1, n2, n3, n4 = rng.standard_normal((4, *waveforms.shape))
        in_phase = signal * n1 + noise * n3
        quadrature = signal * n2 + noise * n4
        total += in_phase**2 + quadrature**2
    return total / n_looks


def render_scatterers(layer_bins, parameters, n_range_bins, *, rng, n_scatterers=100):
    """What `render` gives, as a sum of point scatterers.

    In the manner of the CReSIS toolbox's simulator. Those of a layer and range line are normal
    about it plus an exponential delay, with exponential power and sinc-squared responses on every
    row. They are its only speckle: `n_looks` acts on the noise.
    """
    waveforms = waveforms_of(layer_bins, parameters, n_range_bins)
    noise_power = checked_power("noise_power", parameters["noise_power"])
    noise = np.full(waveforms.shape, noise_power)
    power = draw_speckle(noise, parameters["n_looks"], method="gamma", rng=rng)
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
    """Power averaged over looks with means of their own: the geometry moves.

    `mean_power` is (look, range_bin, range_line). ``looks``: sum of looks. ``gamma``: shape ``(sum
    m)^2 / sum m^2``, right in mean and variance, exact if all equal.
    """
    if method == "looks":
        return draw_looks(mean_power, rng)
    mean = mean_power.mean(axis=0)
    smallest = np.finfo(mean_power.dtype).tiny
    # Relative to the largest, so that squares neither overflow nor vanish.
    relative = mean_power / np.maximum(mean_power.max(axis=0), smallest)
    squares = np.maximum((relative**2).sum(axis=0), smallest)
    matched = np.maximum(relative.sum(axis=0) ** 2 / squares, 1)
    shape = np.where(mean > 0, matched, len(mean_power))
    return draw_gamma(mean, shape.astype(mean.dtype), rng)


def convolved_power(waveforms, samples_per_bin=1):
    """Mean power by numerical convolution of whole columns.

    From above the topmost layer, so that nothing wraps around. Narrow Gaussians alias, fast decays
    are summed coarsely, the transform leaves 1e-16 of the peak everywhere.
    """
    reach = 8 * np.sqrt(waveforms.variance_bins2)
    topmost = np.nanmin(waveforms.centre_bins - reach[:, None], initial=0)
    n_above = int(np.ceil(-topmost)) * samples_per_bin
    n_samples = (waveforms.n_range_bins - 1) * samples_per_bin + 1 + n_above
    sample = np.arange(n_samples)
    x_bins = (sample - n_above) / samples_per_bin
    delay = sample / samples_per_bin
    power = np.zeros((n_samples, waveforms.shape[1]))
    for layer, centre in enumerate(waveforms.centre_bins):
        lines = np.isfinite(centre)
        away = x_bins[:, None] - centre[lines]
        gaussian = np.exp(-(away**2) / (2 * waveforms.variance_bins2[layer]))
        exponential = np.exp(-waveforms.decay_rate[layer] * delay)
        exponential *= waveforms.amplitude[layer]
        exponential /= samples_per_bin
        exponential[0] /= 2  # trapezoids: the exponential starts with a step
        power[:, lines] += fftconvolve(gaussian, exponential[:, None], axes=0)[:n_samples]
    return np.maximum(power[n_above::samples_per_bin], 0)


def waveform_naive(x_bins, variance_bins2, decay_rate):
    """The closed form as it is usually written.

    It overflows for wide or fast-decaying waveforms, NaN in its head.
    """
    x_bins = np.asarray(x_bins, dtype=float)
    z = (decay_rate * variance_bins2 - x_bins) / np.sqrt(2 * variance_bins2)
    exponent = decay_rate**2 * variance_bins2 / 2 - decay_rate * x_bins
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        return np.sqrt(np.pi * variance_bins2 / 2) * np.exp(exponent) * erfc(z)


def table_power(waveforms, noise_power, tolerance_db):
    """Closed form by sub-bin tables within the supports of a tolerance, as `mean_power` does."""
    return planned_power(plan_power(waveforms, noise_power, tolerance_db))


def single_precision_power(waveforms, noise_power, tolerance_db):
    """Sub-bin tables with tables and sums forced into float32; ValueError without supports."""
    supports = _found_supports(waveforms, noise_power, tolerance_db)
    return tabulated_power(waveforms, replace(supports, dtype=np.dtype(np.float32)), 0.0)


def power_in_support(waveforms, noise_power, tolerance_db):
    """Closed form on the rows of each layer's support only; ValueError without supports."""
    supports = _found_supports(waveforms, noise_power, tolerance_db)
    rows = np.arange(waveforms.n_range_bins)[:, None]
    power = np.zeros(waveforms.shape)
    for layer in np.flatnonzero(supports.kept):
        x_bins = rows - waveforms.centre_bins[layer]
        # Nothing where the layer is absent, NaN.
        inside = (x_bins >= supports.first_bins[layer]) & (x_bins <= supports.last_bins[layer])
        power[inside] += layer_power(waveforms, layer, x_bins[inside], waveform_unchecked)
    return power


def recursive_power(waveforms, noise_power, tolerance_db, dtype=float):
    """A filter that steps in `dtype` within the supports, which does not keep the tolerance."""
    supports = _found_supports(waveforms, noise_power, tolerance_db)
    power = np.zeros(waveforms.shape, dtype=dtype)
    _filter_layers(
        waveforms.centre_bins,
        waveforms.amplitude,
        waveforms.variance_bins2,
        waveforms.decay_rate,
        np.where(supports.kept, supports.first_bins, np.nan),
        np.where(supports.kept, supports.last_bins, np.nan),
        power,
    )
    return power


def _found_supports(waveforms, noise_power, tolerance_db):
    supports = find_supports(waveforms, noise_power, allowed_error(tolerance_db))
    if supports is None:
        msg = f"no support keeps {tolerance_db:g} dB with noise_power {noise_power:g}"
        raise ValueError(msg)
    return supports


@numba.njit(cache=True)
def _filter_layers(centre_bins, amplitude, variance, decay, first_bins, last_bins, power):
    """Add layers by recursion: Simpson's rule over a bin of Gaussian, itself stepped by ratios."""
    as_stored = power.dtype.type
    for layer in range(centre_bins.shape[0]):
        fade = as_stored(np.exp(-decay[layer]))
        half_fade = as_stored(4 * np.exp(-decay[layer] / 2))
        bend = as_stored(np.exp(-0.25 / variance[layer]))
        for line in range(centre_bins.shape[1]):
            centre = centre_bins[layer, line]
            start = np.ceil(centre + first_bins[layer])
            stop = min(np.floor(centre + last_bins[layer]) + 1, power.shape[0])
            if not start < stop:
                continue
            x = start - centre
            peak = amplitude[layer] * np.exp(-x * x / (2 * variance[layer]))
            gaussian = as_stored(peak / 6)
            ratio = as_stored(np.exp(-(x / 2 + 0.125) / variance[layer]))
            state = 0.0
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
    """Closed form from 5 deviations above to 150 bins below each Gaussian's centre."""

    def cut(x_bins, variance_bins2, decay_rate):
        inside = (x_bins >= -CUT_DEVIATIONS * np.sqrt(variance_bins2)) & (x_bins <= CUT_BINS)
        return np.where(inside, waveform_unchecked(x_bins, variance_bins2, decay_rate), 0)

    return summed_power(waveforms, cut)


def nearest_power(waveforms, n_phases=16):
    """Closed form with centres moved to the nearest of `n_phases` places a bin.

    So do tables without interpolation.
    """
    nearest_bins = np.rint(waveforms.centre_bins * n_phases) / n_phases
    return exact_power(replace(waveforms, centre_bins=nearest_bins))


def wrapped_power(waveforms):
    """Convolution of columns by Fourier transforms of the window's height, without padding."""
    rows = np.arange(waveforms.n_range_bins)[:, None]

    def wrapped(x_bins, variance_bins2, decay_rate):
        gaussian = np.exp(-(x_bins**2) / (2 * variance_bins2))
        exponential = np.exp(-decay_rate * rows)
        exponential[0] /= 2
        spectrum = np.fft.rfft(gaussian, axis=0) * np.fft.rfft(exponential, axis=0)
        return np.fft.irfft(spectrum, len(rows), axis=0)

    return np.maximum(summed_power(waveforms, wrapped), 0)


def summed_power(waveforms, waveform, rows=None):
    """Sum of all layers on every row, or on some, float64 (row, range_line).

    ``waveform(x_bins, variance_bins2, decay_rate)`` gives one layer of unit amplitude.
    """
    rows = np.arange(waveforms.n_range_bins) if rows is None else rows
    power = np.zeros((len(rows), waveforms.shape[1]))
    for layer, lines in enumerate(np.isfinite(waveforms.centre_bins)):
        x_bins = rows[:, None] - waveforms.centre_bins[layer, lines]
        power[:, lines] += layer_power(waveforms, layer, x_bins, waveform)
    return power


def layer_power(waveforms, layer, x_bins, waveform):
    """Power of one layer at `x_bins` below its centre."""
    one = waveform(x_bins, waveforms.variance_bins2[layer], waveforms.decay_rate[layer])
    return waveforms.amplitude[layer] * one
