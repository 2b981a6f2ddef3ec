"""PHY as printed: eq. (1) convolved, eqs (3)-(4) look by look; and how far a power is from another.

No renderer uses these forms: they are what faster ones are compared with.
"""

import numpy as np
from scipy.signal import fftconvolve

from snowsim.phy.power import checked_waveforms, echoes_of_parameters

VANISHED = 1e-290  # powers below have lost digits to underflow


def planted_scene(n_layers, n_range_lines, n_range_bins, *, n_looks=100):
    """Layers and parameters of `render` that depend on nothing but their number.

    Each layer waves in its own phase.
    """
    depth_bins = n_range_bins * np.linspace(0.2, 0.9, n_layers)
    phase = 2.4 * np.arange(n_layers)[:, None] + np.arange(n_range_lines) / 10
    layer_bins = depth_bins[:, None] + 0.1 * n_range_bins / n_layers * np.sin(phase)
    parameters = {
        "peak_power": np.geomspace(1, 0.02, n_layers),
        "variance_bins2": np.full(n_layers, 12.0),
        "noise_power": 1e-3,
        "decay_rate": np.linspace(0.1, 0.05, n_layers),
        "n_looks": n_looks,
    }
    return layer_bins, parameters


def waveforms_of(layer_bins, parameters, n_range_bins):
    """`Waveforms` of layers and parameters as `render` takes them, by its default conventions."""
    return checked_waveforms(echoes_of_parameters(layer_bins, **parameters), n_range_bins)


def render_as_printed(layer_bins, parameters, n_range_bins, *, rng):
    """What `render` gives, as printed: columns convolved, M looks of 4 normals for every pixel.

    Yari et al. (2021), eqs (1), (3), (4): ``P = 1/M sum |sqrt(P_s / 2) (n1 + i n2) + sqrt(P_n / 2)
    (n3 + i n4)|^2``.
    """
    waveforms = waveforms_of(layer_bins, parameters, n_range_bins)
    signal = np.sqrt(convolved_power(waveforms) / 2)
    noise = np.sqrt(parameters["noise_power"] / 2)
    total = np.zeros(waveforms.shape)
    for _ in range(parameters["n_looks"]):
        n1, n2, n3, n4 = rng.standard_normal((4, *waveforms.shape))
        in_phase = signal * n1 + noise * n3
        quadrature = signal * n2 + noise * n4
        total += in_phase**2 + quadrature**2
    return total / parameters["n_looks"]


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
        away = x_bins[:, None] - centre
        gaussian = np.exp(-(away**2) / (2 * waveforms.variance_bins2[layer]))
        gaussian = np.nan_to_num(gaussian)  # nothing where the layer is absent
        exponential = np.exp(-waveforms.decay_rate[layer] * delay)
        exponential /= samples_per_bin
        exponential[0] /= 2  # trapezoids: the exponential starts with a step
        gaussian *= waveforms.amplitude[layer]
        power += fftconvolve(gaussian, exponential[:, None], axes=0)[:n_samples]
    return np.maximum(power[n_above::samples_per_bin], 0)


def summed_power(waveforms, waveform):
    """Sum of all layers on every pixel, float64 (range_bin, range_line).

    ``waveform(x_bins, variance_bins2, decay_rate)`` gives one layer of unit amplitude.
    """
    rows = np.arange(waveforms.n_range_bins)[:, None]
    power = np.zeros(waveforms.shape)
    for layer, lines in enumerate(np.isfinite(waveforms.centre_bins)):
        x_bins = rows - waveforms.centre_bins[layer, lines]
        one = waveform(x_bins, waveforms.variance_bins2[layer], waveforms.decay_rate[layer])
        power[:, lines] += waveforms.amplitude[layer, lines] * one
    return power


def largest_error_db(power, exact, noise_power):
    """Largest ``|10 log10((power + noise) / (exact + noise))|`` of all pixels [dB].

    Powers below 1e-290 are nothing; infinite where a power is none.
    """
    power = np.asarray(power, dtype=float) + noise_power
    if not (power >= 0).all():
        return np.inf
    exact = np.asarray(exact, dtype=float) + noise_power
    ratio = np.maximum(power, VANISHED) / np.maximum(exact, VANISHED)
    return float(np.abs(10 * np.log10(ratio)).max(initial=0))
