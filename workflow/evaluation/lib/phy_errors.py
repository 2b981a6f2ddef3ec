"""How far PHY's shortcuts are from exact, eq. (1) from an echo; and a scene to measure on."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.special import gammainc, gammaincinv, ndtr, ndtri

from evaluation.lib.phy_alternatives import waveforms_of
from snowsim.phy.correlated import filter_to_power, normal_quantiles
from snowsim.phy.power import exact_power
from snowsim.phy.speckle import quantile_table
from snowsim.phy.waveform import SAFE_RANGE, waveform_exact

VANISHED = 1e-290  # powers below have lost digits to underflow
N_LEVELS = 2000
REACH_BINS = 200  # of the response of a scatterer
MOST_SAMPLES = 150  # of a tail that are fitted: it is smooth


def planted_scene(n_layers, n_range_lines, n_range_bins, *, n_looks=100):
    """Layers and parameters of `render` that depend on nothing but their number.

    Each layer waves in its own phase.
    """
    layer = np.arange(n_layers)
    depth_bins = np.linspace(0.2, 0.9, n_layers)[:, None] * n_range_bins
    spacing_bins = 0.7 * n_range_bins / max(n_layers - 1, 1)
    along = 2 * np.pi * np.arange(n_range_lines) / 64
    phase = along + 2.4 * layer[:, None]
    fading = 0.1 * 0.85 ** np.arange(1, max(n_layers - 4, 1))
    parameters = {
        "peak_power": np.concatenate([[1, 0.3, 0.2, 0.15, 0.1], fading])[:n_layers],
        "variance_bins2": np.full(n_layers, 12.0),
        "noise_power": 1e-3,
        "decay_rate": np.linspace(0.1, 0.05, n_layers),
        "n_looks": n_looks,
    }
    return depth_bins + min(2, 0.2 * spacing_bins) * np.sin(phase), parameters


def largest_error_db(power, exact, noise_power):
    """Largest ``|10 log10((power + noise) / (exact + noise))|`` of all pixels [dB].

    Powers below 1e-290 are nothing.
    """
    power = np.asarray(power, dtype=float) + noise_power
    exact = np.asarray(exact, dtype=float) + noise_power
    vanished = exact < VANISHED
    valid = np.isfinite(power) & (power >= 0)
    if not valid.all() or np.any(power[vanished] > 2 * VANISHED):
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
    above_mean = np.cbrt(level) - 1 + 1 / (9 * n_looks)
    return ndtr(above_mean * 3 * np.sqrt(n_looks))


def quantile_distance(n_looks):
    """Largest distance of the distribution functions of speckle methods `quantile` and `gamma`."""
    table = quantile_table(float(n_looks)).astype(float)
    exact = gammainc(n_looks, n_looks * table)
    before = np.arange(table.size) / table.size
    above_start = exact - before
    above_end = above_start - 1 / table.size
    return float(max(np.abs(above_start).max(), np.abs(above_end).max()))


def correlated_distance(n_looks):
    """Largest distance of the distribution functions of correlated speckle and of `gamma`.

    At a million normals.
    """
    levels = (np.arange(1_000_000) + 0.5) / 1_000_000
    normals = ndtri(levels).astype(np.float32)[:, None]
    taps = np.ones(1, dtype=np.float32)
    power = np.ones(normals.shape)
    filter_to_power(normals, taps, normal_quantiles(float(n_looks)), power, power)
    exact = gammainc(n_looks, n_looks * power)
    return float(np.abs(exact - ndtr(normals.astype(float))).max())


def moving_distance(look_means):
    """Largest distance of the moment-matched Gamma from the sum over looks of means (look,)."""
    look_means = np.asarray(look_means, dtype=float) / np.mean(look_means)
    n_matched = look_means.sum() ** 2 / (look_means**2).sum()
    level, matched = _levels(n_matched)
    return float(np.abs(matched - mean_of_looks_below(level, look_means)).max())


def mean_of_looks_below(level, look_means):
    """Distribution function of the mean of exponential looks of these means, (look,).

    At positive powers (level,). Gil-Pelaez (1951), Biometrika 38, 481-482: ``F(x) = 1/2 - 1/pi int
    Im(exp(-iux) phi(u)) / u du`` with ``phi(u) = prod 1 / (1 - i u m / M)``, summed at odd
    multiples of half a step until phi has fallen to 1e-7.
    """
    level = np.asarray(level, dtype=float)
    scale = np.asarray(look_means, dtype=float) / np.size(look_means)
    # Periodic beyond the last level by 60 decays of the slowest look, 1e-26.
    step = 2 * np.pi / (level.max() + scale.sum() + 60 * scale.max())
    last = step
    while np.log1p((last * scale) ** 2).sum() < 2 * np.log(1e7) and last < 1e6 * step:
        last *= 1.2
    u = step * (np.arange(int(last / step) + 1) + 0.5)
    transform = np.ones(u.size, dtype=complex)
    for one in scale:
        transform /= 1 - 1j * u * one
    below = np.empty(level.size)
    for at, x in enumerate(level):
        integrand = (np.exp(-1j * u * x) * transform / u).imag
        below[at] = 0.5 - step / np.pi * integrand.sum()
    return below


def scattered_mean_power(layer_bins, parameters, n_range_bins):
    """Mean power with noise that `render_scatterers` has.

    Eq. (1) convolved with one bin's sinc-squared response, by sums at quarters of a bin, which
    resolve both; beyond `REACH_BINS` the response, below 3e-6, is left out.
    """
    waveforms = waveforms_of(layer_bins, parameters, n_range_bins)
    power = np.full(waveforms.shape, parameters["noise_power"])
    for shift in np.arange(-REACH_BINS, REACH_BINS, 0.25):
        weight = 0.25 * np.sinc(shift) ** 2
        if weight > 1e-20:
            shifted = replace(waveforms, centre_bins=waveforms.centre_bins + shift)
            power += weight * exact_power(shifted)
    return power


def _levels(n_looks):
    """Powers at evenly likely levels of Gamma(M) / M, and its distribution function there."""
    exact = (np.arange(N_LEVELS) + 0.5) / N_LEVELS
    return gammaincinv(n_looks, exact) / n_looks, exact


@dataclass(frozen=True)
class WaveformFit:
    """Best fit ``amplitude * w(x - offset_bins)`` to an echo, its error over `n_bins` of tail."""

    offset_bins: float
    variance_bins2: float
    decay_rate: float
    amplitude: float
    rms_db: float
    largest_db: float
    n_bins: float


def fit_waveform(x_bins, power, tail_db):
    """Fit eq. (1) to the tail of a mean echo without noise, by least squares in dB.

    The echo is (sample,) at increasing `x_bins`. The tail reaches from the peak to where power has
    first fallen by `tail_db`; what comes before shows the range response. It must have an end and
    six samples.
    """
    x_bins = np.asarray(x_bins, dtype=float)
    power = np.asarray(power, dtype=float)
    valid = np.isfinite(power) & (power >= 0)
    if x_bins.shape != power.shape or power.ndim != 1 or not valid.all():
        msg = "expected positions and powers, finite and not negative, got shapes "
        msg += f"{x_bins.shape} and {power.shape}"
        raise ValueError(msg)
    top = int(power.argmax())
    least = power[top] * 10 ** (-tail_db / 10)
    below = np.flatnonzero(power[top:] < least)
    if not below.size or below[0] < 6:
        has = below[0] if below.size else "no end"
        msg = f"the tail must have six samples and fall by {tail_db:g} dB, has {has}"
        raise ValueError(msg)
    n_tail = int(below[0])
    tail = slice(top, top + n_tail, 1 + n_tail // MOST_SAMPLES)
    x = x_bins[tail] - x_bins[top]
    level_db = 10 * np.log10(power[tail] / power[top])
    best = _least_squares(x, level_db, tail_db)
    offset, log_variance, log_decay, amplitude_db = best.x
    return WaveformFit(
        offset_bins=x_bins[top] + offset,
        variance_bins2=np.exp(log_variance),
        decay_rate=np.exp(log_decay),
        amplitude=power[top] * 10 ** (amplitude_db / 10),
        rms_db=np.sqrt(np.mean(best.fun**2)),
        largest_db=np.abs(best.fun).max(),
        n_bins=x[-1] - x[0],
    )


def _least_squares(x, level_db, tail_db):
    """Best fit of (offset, log variance, log decay, amplitude in dB) to levels over a tail."""

    def residual(parameters):
        offset, log_variance, log_decay, amplitude_db = parameters
        wave = waveform_exact(x - offset, np.exp(log_variance), np.exp(log_decay))
        return 10 * np.log10(np.maximum(wave, 1e-300)) + amplitude_db - level_db

    log_range = np.log(list(SAFE_RANGE.values()))
    low = [-np.inf, *log_range[:, 0], -np.inf]
    high = [np.inf, *log_range[:, 1], np.inf]
    decay = tail_db * np.log(10) / 10 / x[-1]
    fits = []
    # Several starts: the cost has side valleys where a wide Gaussian stands in for a slow decay.
    for variance in (0.3, 10.0):
        for factor in (0.3, 1):
            start = (-1.0, np.log(variance), np.log(factor * decay), 0.0)
            fit = least_squares(residual, start, bounds=(low, high), xtol=1e-12, ftol=1e-12)
            fits.append(fit)
    return min(fits, key=lambda fit: fit.cost)
