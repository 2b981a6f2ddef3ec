"""From a column of firn to the mean power of its scatterers, line by line, as the radar will receive it."""

from dataclasses import dataclass

import numpy as np
from scipy import fft
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.reference.climate import draw_along_track
from snowsim.reference.firn import KOVACS_M3_KG, refractive_index_kovacs95, surface_reflectivity
from snowsim.reference.radar import (
    SATURATION_LEVEL,
    SATURATION_NOISE,
    draw_coherent_noise,
    draw_detected,
    draw_receiver_gain,
    draw_roll_gain,
    interface_waveform,
    quantised,
    range_response,
    received_mean,
    sidelobes,
)

FOOTPRINT_M = 14.5  # along track, Table I of Yari et al. (2021), IEEE JSTARS 14
SURFACE_LENGTH_M = 120.0  # correlation of the surface echo's strength


@dataclass(frozen=True)
class Echo:
    """Mean power of the scatterers of a stretch.

    `sub_bin_power` float32 (range_line, sub_bin): relative to the peak of a mean surface, `margin`
    sub-bins more at either end, `noise_power` its thermal part. `without_echo` bool (range_line,):
    missing range lines.
    """

    sub_bin_power: np.ndarray
    margin: int
    noise_power: float
    without_echo: np.ndarray
    radar: object

    def cropped(self, n_range_bins):
        """The same with fewer range bins."""
        end = n_range_bins * self.radar.n_sub_bins + 2 * self.margin
        return Echo(
            self.sub_bin_power[:, :end],
            self.margin,
            self.noise_power,
            self.without_echo,
            self.radar,
        )

    def mean(self):
        """Mean detected power, (range_bin, range_line)."""
        return received_mean(self.sub_bin_power, self.radar, self.margin).T

    def draw(self, n_looks, *, rng):
        """Detected power of `n_looks` looks, float32 (range_bin, range_line)."""
        power = draw_detected(self.sub_bin_power, self.radar, self.margin, n_looks, rng=rng)
        return np.ascontiguousarray(quantised(power, self.radar.quantisation_db).T)


def draw_echo(column, surface_row, n_range_bins, firn, radar, *, rng):
    """`Echo` of a stretch: surface, horizons, crusts, lenses, fine layering, thermal noise.

    Interfaces scatter incoherently: over a footprint of 14.5 m their height varies by more than a
    wavelength. Multiple reflections are left out; they are of the order of reflectivity squared, 40
    dB down. `surface_row` is (range_line,).
    """
    sub = radar.n_sub_bins
    n_lines = surface_row.size
    margin = range_response(radar).size // 2 + sub
    shape = (n_lines, n_range_bins * sub + 2 * margin)
    roughness_m = np.hypot(radar.roughness_m, column.percolation * firn.percolation_blur_m)
    buried = interface_waveform(radar, radar.horizon_slope, float(roughness_m))
    surface = interface_waveform(radar, radar.surface_slope, radar.roughness_m)
    # The radar is calibrated on a mean surface: its echo peaks at 1, and at the surface's own
    # travel time.
    mean_surface = surface_reflectivity(firn.surface_density_kg_m3)

    at_surface = surface_row * sub + margin
    power = _scatterers(column, at_surface, shape, radar, buried.lead)
    power += _layering(column, at_surface, shape, firn, radar, rng=rng)
    power = _spread(power, buried.power)
    power *= _loss(column, at_surface, shape, radar)[None]
    power *= np.float32(1 / (mean_surface * surface.peak))

    length_lines = SURFACE_LENGTH_M / radar.line_spacing_m
    surface_db = radar.surface_sd_db * draw_along_track(1, n_lines, length_lines, rng=rng)[0]
    _add_surface(
        power, at_surface - surface.lead, surface.power / surface.peak, 10 ** (surface_db / 10)
    )

    power += _spread(power, sidelobes(radar), centred=True)

    noise_db = radar.surface_to_noise_db + radar.sensitivity_sd_db * rng.standard_normal()
    noise_power = 10 ** (-noise_db / 10)
    gain = draw_receiver_gain(n_lines, radar, rng=rng)
    missing = rng.random(n_lines) < radar.missing_rate
    saturated = rng.random(n_lines) < radar.saturated_rate
    power *= (draw_roll_gain(n_lines, radar, rng=rng) * ~missing).astype(np.float32)[:, None]
    power[saturated] = np.minimum(power[saturated], np.float32(SATURATION_LEVEL))
    power += np.where(saturated, SATURATION_NOISE * noise_power, noise_power).astype(np.float32)[
        :, None
    ]
    power += np.float32(noise_power) * draw_coherent_noise(shape[1], radar, rng=rng)
    power *= gain.astype(np.float32)[:, None]
    return Echo(power, margin, float(noise_power), missing, radar)


def _scatterers(column, at_surface, shape, radar, lead):
    """Reflected power of all interfaces at their sub-bins, float32; one between two sub-bins is split linearly."""
    n_lines, n_sub = shape
    bins = np.concatenate([kind.bins for kind in (column.horizons, column.crusts, column.lenses)])
    power = np.concatenate([kind.power for kind in (column.horizons, column.crusts, column.lenses)])
    at = at_surface + bins * radar.n_sub_bins - lead
    whole = np.floor(at).astype(np.int64)
    inside = (whole >= 0) & (whole < n_sub - 1) & (power > 0)
    first = (np.arange(n_lines) * n_sub + whole)[inside]
    share = (at - whole)[inside]
    power = power[inside]
    flat = np.bincount(first, power * (1 - share), minlength=n_lines * n_sub)
    flat += np.bincount(first + 1, power * share, minlength=n_lines * n_sub)
    return flat.reshape(shape).astype(np.float32)


def _layering(column, at_surface, shape, firn, radar, *, rng):
    """Reflected power of the fine layering of density below the surface, float32.

    The footprint averages over patches smaller than itself: of a layering of lateral scale l and
    standard deviation s it sees ``s l / r``, r its radius, correlated between range lines whose
    footprints overlap.
    """
    step_m = radar.bin_size_s / radar.n_sub_bins * SPEED_OF_LIGHT_M_S / 2
    index = refractive_index_kovacs95(firn.surface_density_kg_m3)
    sd = firn.layering_sd_kg_m3 * min(1.0, firn.layering_lateral_m / (FOOTPRINT_M / 2))
    density = draw_layering(*shape, step_m / index, sd, firn.layering_length_m, rng=rng)
    overlap_lines = FOOTPRINT_M / radar.line_spacing_m / 2
    impulse = np.zeros(2 * int(4 * overlap_lines) + 3)
    impulse[impulse.size // 2] = 1
    kept = np.sqrt((gaussian_filter1d(impulse, overlap_lines) ** 2).sum())
    density = gaussian_filter1d(density, overlap_lines, axis=0, mode="wrap", truncate=3)
    jump = np.diff(density, axis=1, prepend=density[:, :1])
    below_bins = (np.arange(shape[1]) - at_surface.mean()) / radar.n_sub_bins
    depth_m = np.interp(below_bins, column.table_bins, column.table_depth_m)
    mean_density = np.interp(below_bins, column.table_bins, column.table_density_kg_m3)
    factor = (
        KOVACS_M3_KG
        / (2 * (1 + KOVACS_M3_KG * mean_density))
        * np.exp(-depth_m / firn.layering_fade_m)
        / kept
    )
    jump *= factor.astype(np.float32)
    jump *= jump
    jump *= np.arange(shape[1], dtype=np.float32) > at_surface[:, None].astype(np.float32)
    return jump


def _spread(power, waveform, *, centred=False):
    """Convolution of every range line with a waveform that begins, or is centred, at zero delay; cut at both ends."""
    n_sub = power.shape[1]
    length = fft.next_fast_len(n_sub + waveform.size - 1, real=True)
    spectrum = fft.rfft(power, length, axis=1)
    spectrum *= fft.rfft(waveform, length)
    first = waveform.size // 2 if centred else 0
    spread = fft.irfft(spectrum, length, axis=1)[:, first : first + n_sub]
    # Rounding of the transform leaves about 1e-7 of the strongest echo, of either sign, where there
    # is none.
    return np.maximum(spread, 0, dtype=np.float32)


def _loss(column, at_surface, shape, radar):
    """Two-way loss of the firn and of the greater range, float32 (sub_bin,)."""
    below_bins = (np.arange(shape[1]) - at_surface.mean()) / radar.n_sub_bins
    depth_m = np.interp(below_bins, column.table_bins, column.table_depth_m)
    spreading = (radar.height_m / (radar.height_m + depth_m)) ** 2
    return (spreading * 10 ** (-radar.attenuation_db_m * depth_m / 10)).astype(np.float32)


def _add_surface(power, first, waveform, strength):
    """Add the surface's waveform, its first sample at fractional sub-bins `first`, (range_line,)."""
    whole = np.floor(first).astype(np.int64)
    share = (first - whole)[:, None]
    shape = np.pad(waveform, 1)
    values = strength[:, None] * ((1 - share) * shape[1:] + share * shape[:-1])
    columns = whole[:, None] + np.arange(values.shape[1])
    lines = np.broadcast_to(np.arange(power.shape[0])[:, None], columns.shape)
    inside = (columns >= 0) & (columns < power.shape[1])
    power[lines[inside], columns[inside]] += values[inside].astype(np.float32)


def draw_layering(n_profiles, n_samples, spacing_m, sd_kg_m3, length_m, *, rng):
    """Fine layering of density about its trend, as in near-surface density logs, (profile, sample) [kg m-3].

    Gaussian of standard deviation `sd_kg_m3`, autocorrelation exponential with 1/e length
    `length_m`, samples `spacing_m` apart. float32: its rounding is 1e-7 of a field known to a few
    percent.
    """
    persistence = np.float32(np.exp(-spacing_m / length_m))
    noise = rng.standard_normal((n_profiles, n_samples), dtype=np.float32)
    # The first sample keeps unit variance: the series starts stationary.
    noise[:, 1:] *= np.sqrt(1 - persistence**2)
    one = np.ones(1, dtype=np.float32)
    return np.float32(sd_kg_m3) * lfilter(
        one, np.array([1, -persistence], dtype=np.float32), noise, axis=1
    )
