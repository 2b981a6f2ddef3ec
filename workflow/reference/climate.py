"""Accumulation and autumn horizons along the line: one climate, shared by every frame and scene."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from reference.line import accumulation_m, line_length_km
from snowsim.seeding import random_stream
from snowsim.snowpack.along_track import draw_along_track

N_YEARS = 160  # more than a window of 1500 range bins can hold at 0.15 m w.e. / yr
N_WAVES = 48
FADE_WAVELENGTHS_KM = (15.0, 200.0)
MOST_CRUSTS = 4


@dataclass(frozen=True)
class Waves:
    """A smooth random function of position, a sum of cosines of zero mean and unit variance."""

    wavenumber_rad_km: np.ndarray
    phase: np.ndarray

    def __call__(self, position_km):
        """Values at positions [km], in an array of the same shape."""
        position_km = np.asarray(position_km, dtype=float)
        angle = np.multiply.outer(position_km, self.wavenumber_rad_km) + self.phase
        return np.sqrt(2 / self.phase.size) * np.cos(angle).sum(axis=-1)


def draw_waves(shortest_km, longest_km, *, rng):
    """`Waves` whose wavelengths are spread evenly in their logarithm."""
    edges = np.linspace(np.log(shortest_km), np.log(longest_km), N_WAVES + 1)
    wavelength_km = np.exp(rng.uniform(edges[:-1], edges[1:]))
    return Waves(2 * np.pi / wavelength_km, rng.uniform(0, 2 * np.pi, N_WAVES))


@dataclass(frozen=True)
class Climate:
    """The years of snow that all frames and scenes share; see `draw_climate`.

    Three arrays are standard normal: `anomaly` (2, year), of accumulation at the two ends of the
    line, last year first; `horizon_strength` (year,), of the density step of each autumn; and
    `crust_strength` (year, crust). `crust_age` (year, crust) says where in its year a crust lies,
    in (0, 1), NaN where there is none. `track_seed` seeds what differs between parallel tracks.
    """

    anomaly: np.ndarray
    horizon_strength: np.ndarray
    crust_age: np.ndarray
    crust_strength: np.ndarray
    track_seed: int
    settings: object

    def percolation(self, place):
        """Degree of percolation, 0 (dry) to 1."""
        firn = self.settings.firn
        above_m = place.elevation_m - firn.percolation_elevation_m
        return float(1 / (1 + np.exp(above_m / firn.percolation_width_m)))

    def fade_depth_m(self, track, place):
        """Depth [m] over which density steps fall to 1/e at a place of a track."""
        firn = self.settings.firn
        waves = track_waves(self.track_seed, track, "fade", *FADE_WAVELENGTHS_KM)
        factor = np.exp(firn.fade_sd * waves(place.position_km))
        return float(firn.fade_least_m + (firn.fade_depth_m - firn.fade_least_m) * factor)

    def draw_accumulation(self, track, position_km, n_years, *, rng):
        """Water equivalent of the slabs between autumn horizons, (slab, range_line) [m w.e.].

        The youngest slab comes first; it is the open year, which no autumn has ended. Water is
        positive because every factor is an exponential. Undulations differ between tracks, years do
        not. `position_km` (range_line,) is evenly spaced along the line.
        """
        settings = self.settings.climate
        wavelengths_km = (settings.undulation_min_km, settings.undulation_max_km)
        waves = track_waves(self.track_seed, track, "undulation", *wavelengths_km)
        turn = np.pi / 2 * position_km / line_length_km()
        at_start, at_end = self.anomaly[:, :n_years]
        anomaly = np.outer(at_start, np.cos(turn)) + np.outer(at_end, np.sin(turn))
        n_lines = position_km.size
        spacing_m = 1e3 * (position_km[1] - position_km[0])
        drift_lines = settings.drift_length_m / spacing_m
        drift = draw_along_track(n_years, n_lines, drift_lines, rng=rng)
        relief_lines = settings.relief_length_m / spacing_m
        relief = draw_along_track(n_years + 1, n_lines, relief_lines, rng=rng)
        # A hollow of an old surface is filled by the snow above: relief does not add up with depth.
        filled = np.diff(relief, axis=0)
        variance = settings.undulation_sd**2 + settings.anomaly_sd**2
        variance = variance + settings.drift_sd**2 + 2 * settings.relief_sd**2
        log_factor = settings.undulation_sd * waves(position_km) + settings.anomaly_sd * anomaly
        log_factor = log_factor + settings.drift_sd * drift + settings.relief_sd * filled
        mean_m = settings.accumulation_factor * accumulation_m(position_km)
        water_m = mean_m * np.exp(log_factor - variance / 2)
        water_m[0] *= settings.open_year
        return water_m


def draw_climate(settings, *, rng):
    """Draw the `Climate` that a flight and its benchmark share.

    For frames and scenes of one run `rng` is always ``random_stream(seed, "climate")``.
    """
    anomaly = rng.standard_normal((2, N_YEARS))
    horizon_strength = rng.standard_normal(N_YEARS)
    n_crusts = np.minimum(rng.poisson(settings.firn.crusts_per_year, N_YEARS), MOST_CRUSTS)
    crust_age = rng.uniform(0.15, 0.85, (N_YEARS, MOST_CRUSTS))
    crust_strength = rng.standard_normal((N_YEARS, MOST_CRUSTS))
    absent = np.arange(MOST_CRUSTS) >= n_crusts[:, None]
    crust_age[absent] = np.nan
    track_seed = int(rng.integers(2**62))
    return Climate(anomaly, horizon_strength, crust_age, crust_strength, track_seed, settings)


@lru_cache(maxsize=64)
def track_waves(track_seed, track, what, shortest_km, longest_km):
    """`Waves` of one track: equal arguments always give the same ones."""
    return draw_waves(shortest_km, longest_km, rng=random_stream(track_seed, what, track))
