"""Mean power of the scatterers in a column of firn, as the radar receives them."""

from dataclasses import dataclass, replace

import numpy as np
from scipy import fft
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

from reference.column import Column, draw_column, surface_reflectivity
from reference.radar import (
    SATURATION_LEVEL,
    SATURATION_NOISE,
    draw_coherent_noise,
    draw_detected,
    draw_receiver_gain,
    draw_roll_gain,
    draw_surface_row,
    interface_waveform,
    quantised,
    range_response,
    received_mean,
    sidelobes,
)
from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.snowpack.along_track import draw_along_track, gaussian_taps
from snowsim.snowpack.firn import KOVACS_M3_KG, refractive_index_kovacs95

FOOTPRINT_M = 14.5  # along track, Table I of Yari et al. (2021), IEEE JSTARS 14
SURFACE_LENGTH_M = 120.0  # correlation length of the surface echo's strength


@dataclass(frozen=True)
class Echo:
    """Mean power of the scatterers under some range lines.

    `sub_bin_power`, float32 (range_line, sub_bin), is relative to the echo's peak at a mean
    surface; it has `margin` sub-bins more than the window at either end. `noise_power` is its
    thermal part. `without_echo`, bool (range_line,), marks missing range lines.
    """

    sub_bin_power: np.ndarray
    margin: int
    noise_power: float
    without_echo: np.ndarray
    radar: object

    def cropped(self, n_range_bins):
        """The first range bins of this echo."""
        end = n_range_bins * self.radar.n_sub_bins + 2 * self.margin
        return replace(self, sub_bin_power=self.sub_bin_power[:, :end])

    def mean(self):
        """Mean detected power, (range_bin, range_line)."""
        return received_mean(self.sub_bin_power, self.radar, self.margin).T

    def draw(self, n_looks, *, rng):
        """Detected power of `n_looks` looks, float32 (range_bin, range_line)."""
        power = draw_detected(self.sub_bin_power, self.radar, self.margin, n_looks, rng=rng)
        return np.ascontiguousarray(quantised(power, self.radar.quantisation_db).T)


@dataclass(frozen=True)
class Stretch:
    """Range lines at positions [km] of a track: row of the surface, firn below it, and its echo."""

    position_km: np.ndarray
    surface_row: np.ndarray
    column: Column
    echo: Echo

    def layer_bins(self):
        """Rows of surface and horizons, (layer, range_line)."""
        return self.column.layer_bins(self.surface_row)


def draw_stretch(climate, settings, track, start_km, n_lines, surface_bin, n_range_bins, *, rng):
    """Draw a `Stretch` from `start_km` of a track on, its surface near row `surface_bin`."""
    radar = settings.radar
    position_km = start_km + np.arange(n_lines) * radar.line_spacing_m / 1e3
    surface_row = draw_surface_row(n_lines, surface_bin, radar, rng=rng)
    column = draw_column(climate, track, position_km, n_range_bins - surface_bin, rng=rng)
    echo = draw_echo(column, surface_row, n_range_bins, settings.firn, radar, rng=rng)
    return Stretch(position_km, surface_row, column, echo)


def draw_echo(column, surface_row, n_range_bins, firn, radar, *, rng):
    """Draw the `Echo` of a stretch: surface, horizons, crusts, lenses, fine layering, noise.

    Interfaces scatter incoherently, since their height varies by more than a wavelength over a
    footprint of 14.5 m. Multiple reflections are neglected; they are of the order of reflectivity
    squared, 40 dB lower. `surface_row` is (range_line,).
    """
    margin = range_response(radar).size // 2 + radar.n_sub_bins
    n_sub = n_range_bins * radar.n_sub_bins + 2 * margin
    at_surface = surface_row * radar.n_sub_bins + margin
    surface = interface_waveform(radar, radar.surface_slope, radar.roughness_m)
    power = _buried(column, at_surface, n_sub, firn, radar, rng=rng)
    # The radar is calibrated on a mean surface, whose echo peaks at 1 and at the travel time of the
    # surface.
    mean_surface = surface_reflectivity(firn.surface_density_kg_m3)
    power *= np.float32(1 / (mean_surface * surface.peak))
    length_lines = SURFACE_LENGTH_M / radar.line_spacing_m
    deviation = draw_along_track(1, surface_row.size, length_lines, rng=rng)[0]
    strength = 10 ** (radar.surface_sd_db * deviation / 10)
    _add_surface(power, at_surface - surface.lead, surface.power / surface.peak, strength)
    power += _spread(power, sidelobes(radar), centred=True)
    return _received(power, margin, radar, rng=rng)


def _buried(column, at_surface, n_sub, firn, radar, *, rng):
    """Power that reaches the radar from below the surface, float32 (range_line, sub_bin)."""
    blur_m = column.percolation * firn.percolation_blur_m
    roughness_m = float(np.hypot(radar.roughness_m, blur_m))
    waveform = interface_waveform(radar, radar.horizon_slope, roughness_m)
    below_bins = (np.arange(n_sub) - at_surface.mean()) / radar.n_sub_bins
    depth_m = np.interp(below_bins, column.table_bins, column.table_depth_m)
    density = np.interp(below_bins, column.table_bins, column.table_density_kg_m3)
    power = _scatterers(column, at_surface, waveform.lead, n_sub, radar)
    power += _layering(at_surface, depth_m, density, firn, radar, rng=rng)
    power = _spread(power, waveform.power)
    # Two-way losses: attenuation in the firn, and spreading over a longer range.
    spreading = (radar.height_m / (radar.height_m + depth_m)) ** 2
    loss = spreading * 10 ** (-radar.attenuation_db_m * depth_m / 10)
    power *= loss.astype(np.float32)
    return power


def _received(power, margin, radar, *, rng):
    """`Echo` of scatterers with the receiver's noise, gain and faults; changes `power`."""
    n_lines, n_sub = power.shape
    noise_db = radar.surface_to_noise_db + radar.sensitivity_sd_db * rng.standard_normal()
    noise_power = 10 ** (-noise_db / 10)
    gain = draw_receiver_gain(n_lines, radar, rng=rng)
    missing = rng.random(n_lines) < radar.missing_rate
    saturated = rng.random(n_lines) < radar.saturated_rate
    roll_gain = draw_roll_gain(n_lines, radar, rng=rng) * ~missing
    power *= roll_gain.astype(np.float32)[:, None]
    power[saturated] = np.minimum(power[saturated], np.float32(SATURATION_LEVEL))
    thermal = np.where(saturated, SATURATION_NOISE * noise_power, noise_power)
    power += thermal.astype(np.float32)[:, None]
    power += np.float32(noise_power) * draw_coherent_noise(n_sub, radar, rng=rng)
    power *= gain.astype(np.float32)[:, None]
    return Echo(power, margin, float(noise_power), missing, radar)


def _scatterers(column, at_surface, lead, n_sub, radar):
    """Reflected power of all buried interfaces, float32 (range_line, sub_bin).

    Each is placed `lead` sub-bins above its own row, so that its echo will peak on that row. An
    interface between two sub-bins is shared linearly by both.
    """
    kinds = (column.horizons, column.crusts, column.lenses)
    bins = np.concatenate([kind.bins for kind in kinds])
    power = np.concatenate([kind.power for kind in kinds])
    at = at_surface + bins * radar.n_sub_bins - lead
    whole = np.floor(at).astype(np.int64)
    inside = (whole >= 0) & (whole < n_sub - 1) & (power > 0)
    n_lines = at_surface.size
    first = (np.arange(n_lines) * n_sub + whole)[inside]
    share = (at - whole)[inside]
    power = power[inside]
    flat = np.bincount(first, power * (1 - share), minlength=n_lines * n_sub)
    flat += np.bincount(first + 1, power * share, minlength=n_lines * n_sub)
    return flat.reshape(n_lines, n_sub).astype(np.float32)


def _layering(at_surface, depth_m, mean_density, firn, radar, *, rng):
    """Reflected power of the fine layering of density below the surface, float32.

    The footprint averages over patches smaller than itself: of a layering with lateral scale l and
    standard deviation s it leaves ``s l / r``, r being the footprint's radius. The layering is
    correlated between range lines whose footprints overlap. `depth_m` and `mean_density` are
    (sub_bin,).
    """
    index = refractive_index_kovacs95(firn.surface_density_kg_m3)
    step_m = radar.sub_bin_s * SPEED_OF_LIGHT_M_S / 2 / index
    sd = firn.layering_sd_kg_m3 * min(1.0, firn.layering_lateral_m / (FOOTPRINT_M / 2))
    n_lines = at_surface.size
    density = draw_layering(n_lines, depth_m.size, step_m, sd, firn.layering_length_m, rng=rng)
    overlap_lines = FOOTPRINT_M / radar.line_spacing_m / 2
    taps = gaussian_taps(overlap_lines, int(4 * overlap_lines) + 1)
    kept = np.sqrt((taps**2).sum())
    density = gaussian_filter1d(density, overlap_lines, axis=0, mode="wrap", truncate=3)
    jump = np.diff(density, axis=1, prepend=density[:, :1])
    # The square of this is `reflectivity` of a step that fades with depth.
    amplitude = KOVACS_M3_KG / (2 * (1 + KOVACS_M3_KG * mean_density))
    fading = np.exp(-depth_m / firn.layering_fade_m)
    jump *= (amplitude * fading / kept).astype(np.float32)
    jump *= jump
    jump *= np.arange(depth_m.size, dtype=np.float32) > at_surface[:, None].astype(np.float32)
    return jump


def _spread(power, waveform, *, centred=False):
    """Convolution of every range line with a waveform, cut to the length of the line.

    The waveform begins at zero delay or, if `centred`, has its middle there.
    """
    n_sub = power.shape[1]
    length = fft.next_fast_len(n_sub + waveform.size - 1, real=True)
    spectrum = fft.rfft(power, length, axis=1)
    spectrum *= fft.rfft(waveform, length)
    first = waveform.size // 2 if centred else 0
    spread = fft.irfft(spectrum, length, axis=1)[:, first : first + n_sub]
    # Where there is no echo, rounding leaves about 1e-7 of the strongest one, of either sign.
    return np.maximum(spread, 0, dtype=np.float32)


def _add_surface(power, first, waveform, strength):
    """Add the surface's waveform in place; `first`, (range_line,), is the sub-bin it begins at."""
    whole = np.floor(first).astype(np.int64)
    share = (first - whole)[:, None]
    shape = np.pad(waveform, 1)
    moved = (1 - share) * shape[1:] + share * shape[:-1]
    values = strength[:, None] * moved
    columns = whole[:, None] + np.arange(values.shape[1])
    lines = np.broadcast_to(np.arange(power.shape[0])[:, None], columns.shape)
    inside = (columns >= 0) & (columns < power.shape[1])
    power[lines[inside], columns[inside]] += values[inside].astype(np.float32)


def draw_layering(n_profiles, n_samples, spacing_m, sd_kg_m3, length_m, *, rng):
    """Draw the fine layering of density about its trend, as logs show it, (profile, sample).

    It is Gaussian with standard deviation `sd_kg_m3`, and its autocorrelation is exponential with
    the 1/e length `length_m`; samples are `spacing_m` apart. float32 rounds by 1e-7 of a field that
    is known to a few percent.
    """
    persistence = np.float32(np.exp(-spacing_m / length_m))
    noise = rng.standard_normal((n_profiles, n_samples), dtype=np.float32)
    # The first sample keeps unit variance: the series starts stationary.
    noise[:, 1:] *= np.sqrt(1 - persistence**2)
    one = np.ones(1, dtype=np.float32)
    recursion = np.array([1, -persistence], dtype=np.float32)
    return np.float32(sd_kg_m3) * lfilter(one, recursion, noise, axis=1)
