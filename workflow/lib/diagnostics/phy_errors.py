"""How far PHY's shortcuts are from exact, and eq. (1) from a given echo; and a planted scene to measure both on."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.special import gammainc, gammaincinv, ndtr, ndtri

from lib.diagnostics.phy_alternatives import waveforms_of
from snowsim.phy.correlated import filter_to_power, normal_quantiles
from snowsim.phy.power import exact_power
from snowsim.phy.speckle import quantile_table
from snowsim.phy.waveform import SAFE_RANGE, waveform_exact

VANISHED = 1e-290  # powers below have lost digits to underflow
N_LEVELS = 2000
MOST_SAMPLES = 150  # of a tail that are fitted: it is smooth


def planted_scene(n_layers, n_range_lines, n_range_bins, *, n_looks=100):
    """Layers and parameters of `render` that depend on nothing but their number, each waving in its own phase."""
    depth = np.linspace(0.2, 0.9, n_layers)[:, None] * n_range_bins
    spacing = 0.7 * n_range_bins / max(n_layers - 1, 1)
    phase = 2 * np.pi * np.arange(n_range_lines) / 64 + 2.4 * np.arange(n_layers)[:, None]
    first = np.array([1, 0.3, 0.2, 0.15, 0.1])
    power = np.concatenate([first, 0.1 * 0.85 ** np.arange(1, max(n_layers - 4, 1))])[:n_layers]
    parameters = {
        "peak_power": power,
        "variance_bins2": np.full(n_layers, 12.0),
        "noise_power": 1e-3,
    }
    parameters |= {"decay_rate": np.linspace(0.1, 0.05, n_layers), "n_looks": n_looks}
    return depth + min(2, 0.2 * spacing) * np.sin(phase), parameters


def largest_error_db(power, exact, noise_power):
    """Largest ``|10 log10((power + noise) / (exact + noise))|`` of all pixels [dB]; powers below 1e-290 are nothing."""
    power, exact = (
        np.asarray(power, dtype=float) + noise_power,
        np.asarray(exact, dtype=float) + noise_power,
    )
    vanished = exact < VANISHED
    if not np.all(np.isfinite(power) & (power >= 0)) or np.any(power[vanished] > 2 * VANISHED):
        return np.inf
    with np.errstate(divide="ignore"):
        error_db = 10 * np.log10(power[~vanished] / exact[~vanished])
    return float(np.abs(error_db).max(initial=0))


def cube_distance(n_looks):
    """Largest distance of the distribution functions of speckle methods `cube` and `gamma`."""
    level, exact = _levels(n_looks)
    return float(np.abs(cube_below(level, n_looks) - exact).max())


def cube_below(level, n_looks):
    """Distribution function of the cube of a normal, Wilson & Hilferty (1931), at `level`."""
    return ndtr((np.cbrt(level) - 1 + 1 / (9 * n_looks)) * 3 * np.sqrt(n_looks))


def quantile_distance(n_looks):
    """Largest distance of the distribution functions of speckle methods `quantile` and `gamma`."""
    table = quantile_table(float(n_looks)).astype(float)
    exact = gammainc(n_looks, n_looks * table)
    step = np.arange(table.size) / table.size
    return float(max(np.abs(exact - step).max(), np.abs(exact - step - 1 / table.size).max()))


def correlated_distance(n_looks):
    """Largest distance of the distribution functions of correlated speckle and of `gamma`, at a million normals."""
    normals = ndtri((np.arange(1_000_000) + 0.5) / 1_000_000).astype(np.float32)[:, None]
    power = np.ones(normals.shape)
    filter_to_power(
        normals, np.ones(1, dtype=np.float32), normal_quantiles(float(n_looks)), power, power
    )
    return float(np.abs(gammainc(n_looks, n_looks * power) - ndtr(normals.astype(float))).max())


def moving_distance(look_means):
    """Largest distance of the moment-matched Gamma from the sum over looks of these means, (look,)."""
    look_means = np.asarray(look_means, dtype=float) / np.mean(look_means)
    n_matched = look_means.sum() ** 2 / (look_means**2).sum()
    level, matched = _levels(n_matched)
    return float(np.abs(matched - mean_of_looks_below(level, look_means)).max())


def mean_of_looks_below(level, look_means):
    """Distribution function, at positive powers (level,), of the mean of exponential looks of these means, (look,).

    Gil-Pelaez (1951), Biometrika 38, 481-482: ``F(x) = 1/2 - 1/pi int Im(exp(-iux) phi(u)) / u du``
    with ``phi(u) = prod 1 / (1 - i u m / M)``, summed at odd multiples of half a step until phi has
    fallen to 1e-7.
    """
    level = np.asarray(level, dtype=float)
    scale = np.asarray(look_means, dtype=float) / np.size(look_means)
    # Periodic beyond the last level by 60 decays of the slowest look, 1e-26.
    step = 2 * np.pi / (level.max() + scale.sum() + 60 * scale.max())
    last = step
    while 0.5 * np.log1p((last * scale) ** 2).sum() < np.log(1e7) and last < 1e6 * step:
        last *= 1.2
    u = step * (np.arange(int(last / step) + 1) + 0.5)
    transform = np.ones(u.size, dtype=complex)
    for one in scale:
        transform /= 1 - 1j * u * one
    return np.array(
        [0.5 - step / np.pi * (np.exp(-1j * u * x) * transform / u).imag.sum() for x in level]
    )


def scattered_mean_power(layer_bins, parameters, n_range_bins, *, align="gaussian", reach_bins=200):
    """Mean power with noise that `render_scatterers` has: eq. (1) convolved with one bin's sinc-squared response.

    By sums at quarters of a bin, which resolve both; beyond `reach_bins` the response, below 3e-6,
    is left out.
    """
    waveforms = waveforms_of(layer_bins, parameters, n_range_bins, "peak", align)
    power = np.full(waveforms.shape, float(parameters["noise_power"]))
    for shift in np.arange(-reach_bins, reach_bins, 0.25):
        weight = 0.25 * np.sinc(shift) ** 2
        if weight > 1e-20:
            power += weight * exact_power(
                replace(waveforms, centre_bins=waveforms.centre_bins + shift)
            )
    return power


def _levels(n_looks):
    """Powers at evenly likely levels of Gamma(M) / M, and its distribution function there."""
    exact = (np.arange(N_LEVELS) + 0.5) / N_LEVELS
    return gammaincinv(n_looks, exact) / n_looks, exact


@dataclass(frozen=True)
class WaveformFit:
    """Best fit ``amplitude * w(x - offset_bins)`` to an echo, and its error over the `n_bins` of tail fitted."""

    offset_bins: float
    variance_bins2: float
    decay_rate: float
    amplitude: float
    rms_db: float
    largest_db: float
    n_bins: float


def fit_waveform(x_bins, power, tail_db):
    """Fit eq. (1) to the tail of a mean echo without noise, (sample,) at increasing `x_bins`, by least squares in dB.

    The tail reaches from the peak to where power has first fallen by `tail_db`; what comes before
    shows the range response. It must have an end and six samples.
    """
    x_bins, power = np.asarray(x_bins, dtype=float), np.asarray(power, dtype=float)
    if (
        x_bins.shape != power.shape
        or power.ndim != 1
        or not (np.isfinite(power) & (power >= 0)).all()
    ):
        msg = f"expected positions and powers, finite and not negative, got shapes {x_bins.shape} and {power.shape}"
        raise ValueError(msg)
    top = int(power.argmax())
    below = np.flatnonzero(power[top:] < power[top] * 10 ** (-tail_db / 10))
    if not below.size or below[0] < 6:
        msg = f"the tail must have six samples and fall by {tail_db:g} dB, has {below[0] if below.size else 'no end'}"
        raise ValueError(msg)
    tail = slice(top, top + int(below[0]), 1 + int(below[0]) // MOST_SAMPLES)
    x, level_db = x_bins[tail] - x_bins[top], 10 * np.log10(power[tail] / power[top])

    def residual(parameters):
        offset, log_variance, log_decay, amplitude_db = parameters
        wave = waveform_exact(x - offset, np.exp(log_variance), np.exp(log_decay))
        return 10 * np.log10(np.maximum(wave, 1e-300)) + amplitude_db - level_db

    decay = tail_db * np.log(10) / 10 / x[-1]
    low, high = (np.log(bounds) for bounds in zip(*SAFE_RANGE.values(), strict=True))
    # Several starts: the cost has side valleys where a wide Gaussian stands in for a slow decay.
    starts = [
        (-1.0, np.log(v), np.log(factor * decay), 0.0) for v in (0.3, 10.0) for factor in (0.3, 1)
    ]
    limits = ([-np.inf, low[0], low[1], -np.inf], [np.inf, high[0], high[1], np.inf])
    fits = [
        least_squares(residual, start, bounds=limits, xtol=1e-12, ftol=1e-12) for start in starts
    ]
    best = min(fits, key=lambda fit: fit.cost)
    offset, log_variance, log_decay, amplitude_db = best.x
    amplitude = power[top] * 10 ** (amplitude_db / 10)
    errors_db = np.sqrt(np.mean(best.fun**2)), np.abs(best.fun).max()
    found = (
        x_bins[top] + offset,
        np.exp(log_variance),
        np.exp(log_decay),
        amplitude,
        *errors_db,
        x[-1] - x[0],
    )
    return WaveformFit(*map(float, found))
