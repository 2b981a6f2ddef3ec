"""The firn under a stretch of range lines: travel time and reflected power of its interfaces."""

from dataclasses import dataclass

import numpy as np

from reference.climate import N_YEARS
from reference.line import Place, place_at
from snowsim.constants import WATER_DENSITY_KG_M3
from snowsim.limits import check_count
from snowsim.snowpack.along_track import draw_along_track
from snowsim.snowpack.firn import (
    KOVACS_M3_KG,
    density_herron_langway80,
    depth_herron_langway80,
    refractive_index_kovacs95,
    travel_time_s,
)

BROKEN_SHARE = 0.15  # of a horizon's step that is left where percolation broke it
# Spread that full percolation adds to the strength of horizons, since it melts whole years away.
MERGED_SD = 0.6
PERCOLATION_FADE = 0.6  # fading depth in full percolation, relative to that of dry firn


@dataclass(frozen=True)
class Interfaces:
    """Interfaces of one kind, two arrays (interface, range_line).

    `bins` are range bins below the surface, `power` is the share of power reflected at nadir.
    """

    bins: np.ndarray
    power: np.ndarray


@dataclass(frozen=True)
class Column:
    """Firn under a stretch of range lines; see `draw_column`.

    `place` is the middle of the stretch and `percolation` its degree, 0 in dry firn to 1. Density
    steps fall to 1/e over `fade_depth_m`. Autumn `horizons` are the layers; `crusts` and `lenses`
    look like them but are none. The three `table_*` (node,) give mean depth and density for range
    bins below the surface.
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
        """Rows of surface and horizons, (layer, range_line), for a surface at `surface_row`."""
        surface = np.zeros_like(surface_row)
        return surface_row + np.vstack([surface, self.horizons.bins])


@dataclass(frozen=True)
class Years:
    """Ends of years, (year, range_line): `bins` and `depth_m` below the surface, and density there.

    Density steps fall to 1/e over `fade_depth_m`.
    """

    bins: np.ndarray
    depth_m: np.ndarray
    density_kg_m3: np.ndarray
    fade_depth_m: float

    def inside(self, year, age):
        """Bins and depth [m] below the surface at shares `age`, (piece, 1), of some years."""
        found = []
        for ends in (self.bins, self.depth_m):
            # The youngest year begins at the surface.
            begins = np.vstack([np.zeros_like(ends[:1]), ends[:-1]])
            found.append((1 - age) * begins[year] + age * ends[year])
        return found


def draw_column(climate, track, position_km, n_bins_below, *, rng):
    """Draw the `Column` of a stretch of a track.

    It holds every horizon that in some range line lies less than `n_bins_below` range bins below
    the surface. Snow is dry and the pulse goes straight down. Depth follows from the steady density
    profile in the middle of the stretch (Sorge's law), so that years with more snow are thicker,
    not denser. `position_km` (range_line,) is evenly spaced along the line.
    """
    firn = climate.settings.firn
    radar = climate.settings.radar
    place = place_at(float(np.mean(position_km)), climate.settings.climate.accumulation_factor)
    percolation = climate.percolation(place)
    record_s = n_bins_below * radar.bin_size_s
    n_years = _n_years(record_s, place.accumulation_m, climate.settings.climate)
    water_m = np.cumsum(climate.draw_accumulation(track, position_km, n_years, rng=rng), axis=0)
    profile = (place.accumulation_m, place.temperature_k, firn.surface_density_kg_m3)
    depth_m = depth_herron_langway80(water_m, *profile)
    years = Years(
        travel_time_s(depth_m, water_m) / radar.bin_size_s,
        depth_m,
        density_herron_langway80(water_m, *profile),
        climate.fade_depth_m(track, place) * (1 - percolation * (1 - PERCOLATION_FADE)),
    )
    horizon_power = _draw_horizons(climate, years, percolation, rng=rng)
    seen = years.bins.min(axis=1) < n_bins_below
    # Else the climate has too few years to fill the window.
    check_count(
        f"years below range bin {n_bins_below} at {place.position_km:.1f} km", (~seen).sum()
    )
    node_water_m = np.linspace(0, water_m.max(), 400)
    node_depth_m = depth_herron_langway80(node_water_m, *profile)
    return Column(
        place=place,
        percolation=percolation,
        fade_depth_m=years.fade_depth_m,
        horizons=Interfaces(years.bins[seen], horizon_power[seen]),
        crusts=_draw_crusts(climate, years, rng=rng),
        lenses=_draw_lenses(climate.settings, years, percolation, rng=rng),
        table_bins=travel_time_s(node_depth_m, node_water_m) / radar.bin_size_s,
        table_depth_m=node_depth_m,
        table_density_kg_m3=density_herron_langway80(node_water_m, *profile),
    )


def _draw_horizons(climate, years, percolation, *, rng):
    """Draw the power that autumn horizons reflect, (year, range_line)."""
    firn = climate.settings.firn
    n_years, n_lines = years.bins.shape
    local_lines = _local_lines(climate.settings)
    year_sd = firn.horizon_year_sd + MERGED_SD * percolation
    of_year = year_sd * climate.horizon_strength[:n_years, None]
    local = firn.horizon_local_sd * draw_along_track(n_years, n_lines, local_lines, rng=rng)
    strength = of_year + local
    jump = firn.horizon_jump_kg_m3 * np.exp(strength - years.depth_m / years.fade_depth_m)
    gap_share = percolation * firn.percolation_gap_share
    jump *= _draw_gaps(n_years, n_lines, local_lines / 2, gap_share, rng=rng)
    return reflectivity(jump, years.density_kg_m3)


def _local_lines(settings):
    """Correlation length of local strength [range lines]."""
    return settings.firn.local_length_m / settings.radar.line_spacing_m


def _n_years(travel_time_below_s, accumulation_m, settings):
    """Number of years that reach a travel time even at least accumulation and in densest firn."""
    # c t / 2 = z + 0.845 w, and w <= 0.7 z in the upper tens of metres, which bounds the mass w.
    optical_m = travel_time_below_s / travel_time_s(1.0, 0.0)
    water_m = optical_m / (1 / 0.7 + KOVACS_M3_KG * WATER_DENSITY_KG_M3)
    spread = np.hypot(settings.undulation_sd, settings.anomaly_sd / 3)
    most_years = water_m / accumulation_m * np.exp(3 * spread) * 1.2
    return min(N_YEARS, int(np.ceil(most_years)) + 4)


def _draw_gaps(n_series, n_lines, correlation_lines, share, *, rng):
    """Draw a factor of steps, (series, range_line): `BROKEN_SHARE` on a `share` of lines, or 1."""
    field = draw_along_track(n_series, n_lines, correlation_lines, rng=rng)
    if share == 0:
        return np.ones_like(field)
    above = field - np.quantile(field, share)
    # Smoothed over a quarter of the field's spread: a break has no sharp edge.
    return BROKEN_SHARE + (1 - BROKEN_SHARE) / (1 + np.exp(-above / 0.25))


def _draw_crusts(climate, years, *, rng):
    """Draw crusts inside the years; they follow the horizons above and below them."""
    firn = climate.settings.firn
    n_years, n_lines = years.bins.shape
    year, crust = np.nonzero(np.isfinite(climate.crust_age[:n_years]))
    age = climate.crust_age[year, crust][:, None]
    bins, depth_m = years.inside(year, age)
    pattern = draw_along_track(year.size, n_lines, _local_lines(climate.settings), rng=rng)
    # Crusts are patchier than horizons: twice the local spread.
    local = 2 * firn.horizon_local_sd * pattern
    strength = firn.crust_sd * climate.crust_strength[year, crust][:, None] + local
    jump = firn.crust_jump_kg_m3 * np.exp(strength - depth_m / years.fade_depth_m)
    return Interfaces(bins, reflectivity(jump, years.density_kg_m3[year]))


def _draw_lenses(settings, years, percolation, *, rng):
    """Draw ice lenses: short bright pieces between the horizons, none in dry firn."""
    firn = settings.firn
    spacing_m = settings.radar.line_spacing_m
    n_years, n_lines = years.bins.shape
    length_km = n_lines * spacing_m / 1e3
    per_m = percolation * firn.lenses_per_km_m * length_km
    n_lenses = int(rng.poisson(per_m * years.depth_m[-1].mean()))
    year = rng.integers(1, n_years, n_lenses)
    age = rng.uniform(0, 1, (n_lenses, 1))
    centre = rng.uniform(0, n_lines, (n_lenses, 1))
    spread = np.exp(0.6 * rng.standard_normal((n_lenses, 1)))
    length_lines = firn.lens_length_m / spacing_m * spread
    across = 2 * (np.arange(n_lines) - centre) / length_lines
    # A lens is thin towards its rim, so that it ends without an edge.
    thickness = np.sqrt(np.maximum(1 - across**2, 0))
    bins, depth_m = years.inside(year, age)
    jump = firn.lens_jump_kg_m3 * thickness * np.exp(-depth_m / years.fade_depth_m)
    return Interfaces(bins, reflectivity(jump, years.density_kg_m3[year]))


def reflectivity(jump_kg_m3, density_kg_m3):
    """Share of power that a small density step reflects, seen straight down; broadcasts.

    Fresnel at normal incidence, ``(dn / 2n)^2``, n from Kovacs et al. (1995). The neglected factor
    ``1 - dn / n`` is below 0.3 dB for steps up to 100 kg m-3.
    """
    index = 1 + KOVACS_M3_KG * density_kg_m3
    return (KOVACS_M3_KG * jump_kg_m3 / (2 * index)) ** 2


def surface_reflectivity(density_kg_m3):
    """Share of power that snow of this density reflects to air, Fresnel at normal incidence."""
    index = refractive_index_kovacs95(density_kg_m3)
    return ((index - 1) / (index + 1)) ** 2
