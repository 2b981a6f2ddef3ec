"""Firn as the radar meets it, real and drawn: power by depth, density steps, slabs along track.

Cores and climates are seen by the flight's radar as `snowsim.simulate` sees them.
"""

from dataclasses import replace
from itertools import combinations

import numpy as np

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import to_db
from snowsim.phy import mean_power
from snowsim.physical import PRESETS, Climate, Snowpack, physical_parameters
from snowsim.reference import checked_settings
from snowsim.reference.column import draw_column
from snowsim.reference.echo import FOOTPRINT_M, draw_layering
from snowsim.reference.firn import (
    KOVACS_M3_KG,
    depth_herron_langway80,
    refractive_index_kovacs95,
    travel_time_s,
)
from snowsim.reference.line import line_length_km

RADAR = PRESETS["snow-2012"]
POWER = "power relative to the surface's peak at * m"
STEPS = "density steps between range cells at * m"
DEPTHS_M = ((0.5, 2), (4, 6), (10, 12), (14, 16))
STEP_DEPTHS_M = ((0.5, 5), (5, 15))
CORE_STEP_M = 0.0015  # a core's samples further apart have a gap between them
# Of the flight's interior, and of the core's site.
SITE = (0.18, 243.0, 340.0)  # accumulation [m w.e.], temperature [K], density at the surface
CLIMATE = Climate(accumulation_m=SITE[0], temperature_k=SITE[1], n_years=60)
CLIMATE_LINES = 32  # 200 m apart, in each of as many climates as there are places
CLIMATE_SPACING_M = 200.0
ABOVE_ROWS = 5  # where the peak of the surface may lie, above its picks
N_PLACES = 16
RECORD_S = 173.16e-9  # of the flight's columns, some 20 m
LAGS = np.array([16, 32, 64, 128, 255])
BANDS = ((16, 64), (64, 256), (256, 2048))  # wavelengths [traces]
LEAST_TRACES = 256  # of a block whose spectrum is taken; else the longest wavelength of a band
SEPARATIONS = (2, 6)
GROWTH = "slabs, exponent of the structure function, lags 16 to 255"
SHARED = "slabs, correlation 2 to 6 apart at wavelengths of * lines"


def keyed(name, ranges):
    """A quantity's name for each range."""
    return [name.replace("*", f"{low:g} to {high:g}") for low, high in ranges]


def site_delay_s(depth_m):
    """Two-way travel time from the surface to depths [s]."""
    water_m = np.linspace(0, 20, 2000)
    known_m = depth_herron_langway80(water_m, *SITE)
    return np.interp(depth_m, known_m, travel_time_s(known_m, water_m))


def describe_power(picture):
    """Mean power of depths relative to the peak of the mean surface echo, noise taken off [dB].

    Depths are those of travel times. NaN beyond the data or below the noise.
    """
    ends = np.rint(site_delay_s(np.array(DEPTHS_M)) / picture.row_s).astype(int)
    below = picture.below_surface(-ABOVE_ROWS, ends.max())
    known = below[np.isfinite(below).all(axis=1)]
    profile = np.mean(10 ** (known / 10), axis=1) - picture.noise()
    peak = profile[: 3 * ABOVE_ROWS].max()
    levels = []
    for first, end in ends + ABOVE_ROWS:
        power = profile[first:end].mean() / peak if end <= len(profile) else np.nan
        levels.append(to_db(power) if power > 0 else np.nan)
    return dict(zip(keyed(f"firn, {POWER}", DEPTHS_M), levels, strict=True))


def power_by_depth(snowpack, radar):
    """The same of a snowpack as a radar sees it, (depth range,) [dB]."""
    below_s, parameters = physical_parameters(snowpack, radar)
    lead = int(np.ceil(4 * radar.cell_s / radar.bin_s))
    n_bins = lead + int(below_s[-1].min() / radar.bin_s)
    rendered = mean_power(
        lead + below_s / radar.bin_s,
        **parameters,
        n_range_bins=n_bins,
        normalise="none",
        align="gaussian",
    )
    profile = rendered.mean(axis=1)
    depth_m = delay_depth(snowpack, (np.arange(n_bins) - lead) * radar.bin_s)
    levels = []
    for low_m, high_m in DEPTHS_M:
        within = (depth_m >= low_m) & (depth_m < high_m)
        levels.append(to_db(profile[within].mean() / profile.max()))
    return np.array(levels)


def delay_depth(snowpack, delay_s):
    """Depth of two-way travel times in the mean of a snowpack's range lines [m]."""
    depth_m = snowpack.depth_m.mean(axis=1)
    index = refractive_index_kovacs95(snowpack.density_kg_m3[:-1].mean(axis=1))
    at_s = 2 / SPEED_OF_LIGHT_M_S * np.cumsum(np.append(0, index * np.diff(depth_m)))
    return np.interp(delay_s, at_s, depth_m)


def as_flown(snowpack, radar):
    """The same with the slopes that a radar's settings give the surface and horizons."""
    slope = np.full(len(snowpack.depth_m), radar.horizon_slope)
    slope[0] = radar.surface_slope
    return replace(snowpack, slope=slope, roughness_m=radar.roughness_m)


def core_snowpack(depth_m, density_kg_m3, **others):
    """`Snowpack` of a core sampled every millimetre; wider steps of depth are gaps."""
    gap = np.flatnonzero(np.diff(depth_m) > CORE_STEP_M) + 1
    middle_m = (depth_m[gap - 1] + depth_m[gap]) / 2
    depth_m = np.insert(depth_m, gap, middle_m)
    return Snowpack.from_profile(depth_m, np.insert(density_kg_m3, gap, np.nan), **others)


def cell_m():
    """Range cell of the flight's radar in firn [m]."""
    index = refractive_index_kovacs95(SITE[2])
    return RADAR.cell_s * SPEED_OF_LIGHT_M_S / 2 / index


def describe_core_firn(depth_m, density_kg_m3):
    """Power against depth and density steps of a core, to hold flight and climate against.

    As the radar of the flight's default settings sees it.
    """
    snow = as_flown(core_snowpack(depth_m, density_kg_m3), checked_settings({}).radar)
    levels = power_by_depth(snow, RADAR)
    steps = cell_steps(depth_m, density_kg_m3)
    numbers = {}
    for side in ("firn", "Climate"):
        numbers |= dict(zip(keyed(f"{side}, {POWER}", DEPTHS_M), levels, strict=True))
        numbers |= dict(zip(keyed(f"{side}, {STEPS}", STEP_DEPTHS_M), steps, strict=True))
    return numbers


def cell_steps(depth_m, density_kg_m3):
    """Root mean square difference of neighbouring range cells' mean density, (depth range,)."""
    cell = (depth_m / cell_m()).astype(int)
    n_samples = np.bincount(cell)
    known = n_samples > n_samples.max() / 2
    mean = np.bincount(cell, density_kg_m3) / np.maximum(n_samples, 1)
    middle_m = (np.arange(n_samples.size) + 0.5) * cell_m()
    steps = []
    for low_m, high_m in STEP_DEPTHS_M:
        within = known & (middle_m >= low_m) & (middle_m < high_m)
        both = within[1:] & within[:-1]
        steps.append(np.sqrt(np.mean(np.diff(mean)[both] ** 2)))
    return np.array(steps)


def describe_climate_firn(radar, *, rng):
    """Numbers of `CLIMATE`'s snow under a radar of the flight's settings, a draw each."""
    drawn = []
    for _ in range(N_PLACES):
        snow = CLIMATE.draw(CLIMATE_LINES, CLIMATE_SPACING_M, rng=rng)
        levels = power_by_depth(as_flown(snow, radar), RADAR)
        jump = np.diff(snow.density_kg_m3, axis=0, prepend=np.nan)
        steps = [steps_of(snow.depth_m, jump, *ends) for ends in STEP_DEPTHS_M]
        numbers = dict(zip(keyed(f"Climate, {POWER}", DEPTHS_M), levels, strict=True))
        drawn.append(
            numbers | dict(zip(keyed(f"Climate, {STEPS}", STEP_DEPTHS_M), steps, strict=True))
        )
    return drawn


def steps_of(depth_m, jump, low_m, high_m):
    """Root mean square of single steps of density, as a step of every range cell."""
    within = (depth_m >= low_m) & (depth_m < high_m)
    n_cells = (high_m - low_m) / cell_m() * depth_m.shape[1]
    return np.sqrt(np.nansum(np.where(within, jump, 0) ** 2) / n_cells)


def describe_flight_firn(climate, settings, *, rng):
    """Density steps as the flight's footprint sees them, by place: horizons, crusts and layering.

    A place each.
    """
    places = []
    n_bins = round(RECORD_S / settings.radar.bin_size_s)
    for share in (np.arange(N_PLACES) + 0.5) / N_PLACES:
        lines_km = share * line_length_km() + np.array([0, 0.01])
        column = draw_column(climate, "cores", lines_km, n_bins, rng=rng)
        steps = [_column_steps(column, settings.firn, ends, rng=rng) for ends in STEP_DEPTHS_M]
        places.append(dict(zip(keyed(f"firn, {STEPS}", STEP_DEPTHS_M), steps, strict=True)))
    return places


def _column_steps(column, firn, ends, *, rng):
    """Steps of a column over a range of depths, of all that reflects [kg m-3]."""
    squares = [_layering_steps(firn, ends, rng=rng) ** 2]
    for kind in (column.horizons, column.crusts, column.lenses):
        depth_m = np.interp(kind.bins, column.table_bins, column.table_depth_m)
        density = np.interp(kind.bins, column.table_bins, column.table_density_kg_m3)
        jump = np.sqrt(kind.power) * 2 * refractive_index_kovacs95(density) / KOVACS_M3_KG
        squares.append(steps_of(depth_m, jump, *ends) ** 2)
    return np.sqrt(np.sum(squares))


def _layering_steps(firn, ends, *, rng):
    """Steps between range cells of fine layering over a range of depths [kg m-3]."""
    low_m, high_m = ends
    sd = firn.layering_sd_kg_m3 * min(1.0, firn.layering_lateral_m / (FOOTPRINT_M / 2))
    spacing_m = cell_m() / 16
    cells = draw_layering(64, 16 * 200, spacing_m, sd, firn.layering_length_m, rng=rng)
    means = cells.reshape(64, 200, 16).mean(axis=2)
    fading = np.exp(-(low_m + high_m) / 2 / firn.layering_fade_m)
    return fading * np.sqrt(np.mean(np.diff(means, axis=1) ** 2))


def structure(thickness):
    """Mean square difference of whole slabs (slab, range_line) at `LAGS`, over slabs, (lag,)."""
    return np.array([np.mean((thickness[:, lag:] - thickness[:, :-lag]) ** 2) for lag in LAGS])


def exponent(structures):
    """Power of the lag with which the mean of structure functions grows."""
    mean = np.mean(structures, axis=0)
    if not (mean > 0).all():
        return np.nan
    return np.polyfit(np.log(LAGS), np.log(mean), 1)[0]


def shared_power(thickness, traces):
    """Cross power and power of slabs some `SEPARATIONS` apart in a band of wavelengths [traces].

    Sums over pairs and whole blocks, detrended and tapered.
    """
    shortest, longest = traces
    n_traces = max(longest, LEAST_TRACES)
    n_blocks = thickness.shape[1] // n_traces
    whole = thickness[:, : n_blocks * n_traces]
    blocks = whole.reshape(len(whole), n_blocks, n_traces)
    blocks = blocks[np.isfinite(blocks).all(axis=(1, 2))]
    if blocks.size == 0:
        return np.zeros(2)
    position = np.linspace(-1, 1, n_traces)
    slope = blocks @ position / (position @ position)
    level = blocks.mean(axis=2, keepdims=True)
    tapered = (blocks - level - slope[..., None] * position) * np.hanning(n_traces)
    frequency = np.fft.rfftfreq(n_traces)
    inside = (frequency >= 1 / longest) & (frequency < 1 / shortest)
    spectra = np.fft.rfft(tapered, axis=2)[..., inside]
    spectra /= np.sqrt(np.mean(np.abs(spectra) ** 2, axis=(1, 2), keepdims=True))
    least, most = SEPARATIONS
    crosses = [
        np.mean(np.real(spectra[one] * spectra[other].conj()))
        for one, other in combinations(range(len(spectra)), 2)
        if least <= other - one <= most
    ]
    return np.array([np.sum(crosses), len(crosses)])


def correlation_of(sums):
    """Correlation of slabs from sums of `shared_power`."""
    cross, n_pairs = np.sum(sums, axis=0)
    return cross / n_pairs if n_pairs else np.nan


def describe_slabs(slabs):
    """Units and statistic by quantity, of thicknesses (slab, range_line) of scenes."""
    whole = [thickness[np.isfinite(thickness).all(axis=1)] for thickness in slabs]
    long = [thickness for thickness in whole if thickness.size and thickness.shape[1] > LAGS[-1]]
    found = {GROWTH: ([structure(thickness) for thickness in long], exponent)}
    for name, traces in zip(keyed(SHARED, BANDS), BANDS, strict=True):
        sums = [shared_power(thickness, traces) for thickness in long]
        found[name] = (sums, correlation_of)
    return found


def describe_real_slabs(horizons):
    """Numbers of real horizons (horizon, trace) by frame: a slab, or all of them."""
    thickness = np.diff(horizons, axis=0)
    numbers = {
        f"GreenTRACS slab {number + 1}": {GROWTH: exponent([structure(slab[None])])}
        for number, slab in enumerate(thickness)
    }
    numbers["GreenTRACS, all slabs"] = {
        name: correlation_of([shared_power(thickness, traces)])
        for name, traces in zip(keyed(SHARED, BANDS), BANDS, strict=True)
    }
    return numbers
