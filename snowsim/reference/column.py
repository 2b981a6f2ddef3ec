"""The firn under a stretch of range lines: where its interfaces lie in fast time and how strong they are."""

from dataclasses import dataclass

import numpy as np

from snowsim.constants import WATER_DENSITY_KG_M3
from snowsim.reference.climate import N_YEARS, draw_along_track
from snowsim.reference.firn import (
    KOVACS_M3_KG,
    density_herron_langway80,
    depth_herron_langway80,
    reflectivity,
    travel_time_s,
)
from snowsim.reference.line import Place, place_at

BROKEN_SHARE = 0.15  # what is left of a horizon's step where percolation broke it
MERGED_SD = (
    0.6  # additional spread of the horizons' strength in full percolation: whole years melt away
)
PERCOLATION_FADE = 0.6  # depth of fading in full percolation, relative to dry firn


@dataclass(frozen=True)
class Interfaces:
    """Interfaces of one kind, (interface, range_line): bins below the surface, power reflected at nadir (0: none)."""

    bins: np.ndarray
    power: np.ndarray


@dataclass(frozen=True)
class Column:
    """Firn under a stretch of range lines; see `draw_column`.

    `place` is its middle; `percolation` 0 (dry) to 1; density steps fall to 1/e over
    `fade_depth_m`. Autumn `horizons` are the layers; `crusts` and `lenses` look like them.
    `table_*` (node,): mean depth, density by bins below.
    """

    place: Place
    percolation: float
    fade_depth_m: float
    horizons: Interfaces
    crusts: Interfaces
    lenses: Interfaces
    table_bins: np.ndarray
    table_depth_m: np.ndarray
    table_density_kg_m3: np.ndarray

    def layer_bins(self, surface_row):
        """Surface and horizons as rows of a record whose surface lies at these rows, (layer, range_line)."""
        return surface_row + np.vstack([np.zeros_like(surface_row), self.horizons.bins])


def draw_column(climate, track, position_km, n_bins_below, *, rng):
    """`Column` of a stretch of a track, with every horizon that lies above `n_bins_below` in some range line.

    Snow is dry, the pulse goes straight down, and the density profile that gives depth is the
    steady one of the stretch's middle (Sorge's law): years with more snow are thicker, not denser.
    `position_km` (range_line,) is evenly spaced along the line; `n_bins_below` counts range bins
    from the surface.
    """
    firn, radar = climate.settings.firn, climate.settings.radar
    place = place_at(float(np.mean(position_km)), climate.settings.climate.accumulation_factor)
    percolation = climate.percolation(place)
    fade_depth_m = climate.fade_depth_m(track, place) * (1 - percolation * (1 - PERCOLATION_FADE))

    n_years = _n_years(
        n_bins_below * radar.bin_size_s, place.accumulation_m, climate.settings.climate
    )
    water_m = np.cumsum(climate.draw_accumulation(track, position_km, n_years, rng=rng), axis=0)
    profile = (place.accumulation_m, place.temperature_k, firn.surface_density_kg_m3)
    depth_m = depth_herron_langway80(water_m, *profile)
    density = density_herron_langway80(water_m, *profile)
    bins = travel_time_s(depth_m, water_m) / radar.bin_size_s

    n_lines = position_km.size
    local_lines = firn.local_length_m / radar.line_spacing_m
    strength = (firn.horizon_year_sd + MERGED_SD * percolation) * climate.horizon_strength[
        :n_years, None
    ]
    strength = strength + firn.horizon_local_sd * draw_along_track(
        n_years, n_lines, local_lines, rng=rng
    )
    jump = firn.horizon_jump_kg_m3 * np.exp(strength - depth_m / fade_depth_m)
    jump *= _draw_gaps(
        n_years, n_lines, local_lines / 2, percolation * firn.percolation_gap_share, rng=rng
    )

    seen = bins.min(axis=1) < n_bins_below
    if seen.all():
        msg = f"{n_years} years do not reach range bin {n_bins_below} at {place.position_km:.1f} km"
        raise ValueError(msg)
    node_water_m = np.linspace(0, water_m.max(), 400)
    node_depth_m = depth_herron_langway80(node_water_m, *profile)
    return Column(
        place=place,
        percolation=percolation,
        fade_depth_m=fade_depth_m,
        horizons=Interfaces(bins[seen], reflectivity(jump, density)[seen]),
        crusts=_draw_crusts(climate, bins, depth_m, density, fade_depth_m, local_lines, rng=rng),
        lenses=_draw_lenses(climate, bins, depth_m, density, fade_depth_m, percolation, rng=rng),
        table_bins=travel_time_s(node_depth_m, node_water_m) / radar.bin_size_s,
        table_depth_m=node_depth_m,
        table_density_kg_m3=density_herron_langway80(node_water_m, *profile),
    )


def _n_years(travel_time_below_s, accumulation_m, settings):
    """Number of years certain to reach a travel time: least accumulation, densest firn."""
    # c t / 2 = z + 0.845 w, and w <= 0.7 z in the upper tens of metres: the mass cannot exceed
    # this.
    optical_m = travel_time_below_s / travel_time_s(1.0, 0.0)
    water_m = optical_m / (1 / 0.7 + KOVACS_M3_KG * WATER_DENSITY_KG_M3)
    spread = np.hypot(settings.undulation_sd, settings.anomaly_sd / 3)
    return min(N_YEARS, int(np.ceil(water_m / accumulation_m * np.exp(3 * spread) * 1.2)) + 4)


def _draw_gaps(n_series, n_lines, correlation_lines, share, *, rng):
    """Factor of a horizon's step: 1, or `BROKEN_SHARE` over a `share` of its range lines, (series, range_line)."""
    field = draw_along_track(n_series, n_lines, correlation_lines, rng=rng)
    if share == 0:
        return np.ones_like(field)
    threshold = np.quantile(field, share)
    # Smoothed over a quarter of the field's spread: a break has no sharp edge.
    return BROKEN_SHARE + (1 - BROKEN_SHARE) / (1 + np.exp(-(field - threshold) / 0.25))


def _draw_crusts(climate, bins, depth_m, density, fade_depth_m, local_lines, *, rng):
    """Crusts inside the years, which follow the horizons around them."""
    firn = climate.settings.firn
    year, crust = np.nonzero(np.isfinite(climate.crust_age[: len(bins)]))
    age = climate.crust_age[year, crust][:, None]
    # The year above the youngest horizon begins at the surface.
    top = [np.vstack([np.zeros_like(field[:1]), field[:-1]])[year] for field in (bins, depth_m)]
    bins_there, depth_there_m = (
        (1 - age) * t + age * f[year] for t, f in zip(top, (bins, depth_m), strict=True)
    )
    # Crusts are patchier than horizons: twice the local spread.
    local = (
        2 * firn.horizon_local_sd * draw_along_track(year.size, bins.shape[1], local_lines, rng=rng)
    )
    strength = firn.crust_sd * climate.crust_strength[year, crust][:, None] + local
    jump = firn.crust_jump_kg_m3 * np.exp(strength - depth_there_m / fade_depth_m)
    return Interfaces(bins_there, reflectivity(jump, density[year]))


def _draw_lenses(climate, bins, depth_m, density, fade_depth_m, percolation, *, rng):
    """Ice lenses: short bright pieces between the horizons, none in dry firn."""
    firn, radar = climate.settings.firn, climate.settings.radar
    n_lines = bins.shape[1]
    length_km = n_lines * radar.line_spacing_m / 1e3
    n_lenses = int(rng.poisson(percolation * firn.lenses_per_km_m * length_km * depth_m[-1].mean()))
    year = rng.integers(1, len(bins), n_lenses)
    age = rng.uniform(0, 1, (n_lenses, 1))
    centre = rng.uniform(0, n_lines, (n_lenses, 1))
    length_lines = (
        firn.lens_length_m / radar.line_spacing_m * np.exp(0.6 * rng.standard_normal((n_lenses, 1)))
    )
    across = 2 * (np.arange(n_lines) - centre) / length_lines
    depth_there_m = (1 - age) * depth_m[year - 1] + age * depth_m[year]
    # Thin towards the rim: a lens ends without an edge.
    jump = (
        firn.lens_jump_kg_m3
        * np.sqrt(np.maximum(1 - across**2, 0))
        * np.exp(-depth_there_m / fade_depth_m)
    )
    power = reflectivity(jump, density[year])
    return Interfaces((1 - age) * bins[year - 1] + age * bins[year], power)
