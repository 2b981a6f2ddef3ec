"""Snow: interfaces and densities along track, given, or drawn from a climate."""

from dataclasses import dataclass

import numpy as np

from snowsim.constants import ICE_DENSITY_KG_M3
from snowsim.reference.climate import draw_along_track
from snowsim.reference.firn import density_herron_langway80, depth_herron_langway80

# Of undulations, as the reference flight's: log of a year's accumulation from place to place, and lengths along track.
DRIFT_SD, DRIFT_LENGTH_M, DENSITY_LENGTH_M = 0.1, 3000.0, 900.0


@dataclass(frozen=True, eq=False)
class Snowpack:
    """Dry snow below its surface; depths that do not increase and values out of range are refused.

    `depth_m` (layer,) or (layer, range_line): interfaces below the level of the mean surface [m], the surface first,
    at 0 or its own height, down positive. `density_kg_m3`, alike: of the snow below each interface, at most ice's. By
    layer or for all: `roughness_m`, standard deviation of height within a footprint, and `slope`, its rms along one
    axis as seen from the air, in (0, 1]. `attenuation_db_m`: two-way, beside what interfaces reflect.
    """

    depth_m: np.ndarray
    density_kg_m3: np.ndarray
    roughness_m: np.ndarray = 0.02
    slope: np.ndarray = 0.03
    attenuation_db_m: float = 0.0

    def __post_init__(self):
        held = {name: np.asarray(value, dtype=float) for name, value in vars(self).items()}
        for name in ("depth_m", "density_kg_m3"):
            held[name] = held[name][:, None] if held[name].ndim == 1 else held[name]
        shape = np.broadcast_shapes(held["depth_m"].shape, held["density_kg_m3"].shape)
        shapes = (shape, shape, shape[:1], shape[:1], ())
        held = {name: np.broadcast_to(value, to) for (name, value), to in zip(held.items(), shapes, strict=True)}
        above = np.r_["0,2", np.full(shape, -np.inf)[:1], held["depth_m"][:-1]]
        below_zero = np.nextafter(0, -1)
        least = (above, below_zero, below_zero, 0, below_zero)
        most = (np.inf, ICE_DENSITY_KG_M3, np.inf, 1, np.inf)
        for (name, value), low, high in zip(held.items(), least, most, strict=True):
            good = np.isfinite(value) & (value > low) & (value <= high)
            if not good.all():
                rule = "increase with layer" if name == "depth_m" else f"lie between 0 and {high:g}"
                msg = f"snowpack: {name} must be finite and {rule}, got {value[~good][0]:g} at {np.argwhere(~good)[0]}"
                raise ValueError(msg)
            object.__setattr__(self, name, value)


@dataclass(frozen=True, kw_only=True)
class Climate:
    """What annual layers of dry snow are drawn from.

    `accumulation_m` [m w.e. / yr]; `variability`, of its logarithm from year to year: cores, 0.17-0.28; `n_years` of
    layers; `temperature_k`, annual mean: Summit of Greenland; `density_sd_kg_m3` about the mean: cores, 18-39.
    """

    accumulation_m: float
    variability: float = 0.2
    n_years: int = 20
    temperature_k: float = 243.0
    surface_density_kg_m3: float = 340.0
    density_sd_kg_m3: float = 30.0

    def draw(self, n_range_lines, line_spacing_m, *, rng):
        """`Snowpack` of annual layers below a flat surface, depth and mean density by Herron & Langway (1980)."""
        if not (self.n_years >= 1 and min(self.variability, self.density_sd_kg_m3) >= 0):
            msg = f"climate: n_years must be at least 1, variability and density_sd_kg_m3 not negative, got {self}"
            raise ValueError(msg)
        firn = (self.accumulation_m, self.temperature_k, self.surface_density_kg_m3)
        drift = draw_along_track(self.n_years, n_range_lines, DRIFT_LENGTH_M / line_spacing_m, rng=rng)
        logs = self.variability * rng.standard_normal((self.n_years, 1)) + DRIFT_SD * drift
        water_m = self.accumulation_m * np.exp(logs - (self.variability**2 + DRIFT_SD**2) / 2)
        water_m = np.cumsum(np.r_[np.zeros((1, n_range_lines)), water_m], axis=0)
        middle_m = np.r_[(water_m[:-1] + water_m[1:]) / 2, water_m[-1:]]
        share = density_herron_langway80(middle_m, *firn) / ICE_DENSITY_KG_M3
        anomaly = draw_along_track(self.n_years + 1, n_range_lines, DENSITY_LENGTH_M / line_spacing_m, rng=rng)
        # In logits: of the s.d. asked for at the top, never below nothing or above ice.
        width = self.density_sd_kg_m3 / ICE_DENSITY_KG_M3 / (share[0] * (1 - share[0]))
        density = ICE_DENSITY_KG_M3 / (1 + (1 - share) / share * np.exp(-width * anomaly))
        return Snowpack(depth_herron_langway80(water_m, *firn), density)
