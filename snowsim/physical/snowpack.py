"""Snow: interfaces and densities along track, given, or drawn from a climate."""

from dataclasses import dataclass

import numpy as np

from snowsim.constants import ICE_DENSITY_KG_M3
from snowsim.reference.climate import draw_along_track
from snowsim.reference.firn import density_herron_langway80, depth_herron_langway80


@dataclass(frozen=True, eq=False)
class Snowpack:
    """Dry snow below its surface.

    Parameters
    ----------
    depth_m : array_like, (layer,) or (layer, range_line)
        Interfaces below the level of the mean surface, the surface first [m]: 0, or its own height, down positive.
    density_kg_m3 : array_like, (layer,) or (layer, range_line)
        Of the snow below each interface [kg m-3].
    roughness_m : float or array_like, (layer,), optional
        Standard deviation of an interface's height within a footprint [m].
    slope : float or array_like, (layer,), optional
        Its rms slope along one axis, as seen from the air [1].
    attenuation_db_m : float, optional
        Two-way, beside what interfaces reflect [dB/m].

    Raises
    ------
    ValueError
        If depths do not increase, densities leave [0, 917], a roughness or an attenuation is negative, a slope is not
        in (0, 1], or shapes differ.
    """

    depth_m: np.ndarray
    density_kg_m3: np.ndarray
    roughness_m: float | np.ndarray = 0.02
    slope: float | np.ndarray = 0.03
    attenuation_db_m: float = 0.0

    def __post_init__(self):
        depth_m = np.asarray(self.depth_m, dtype=float)
        depth_m = depth_m[:, None] if depth_m.ndim == 1 else depth_m
        density = np.asarray(self.density_kg_m3, dtype=float)
        density = density[:, None] if density.ndim == 1 else density
        if depth_m.ndim != 2 or not depth_m.size or density.ndim != 2 or density.shape[0] != depth_m.shape[0]:
            shapes = f"{np.shape(self.depth_m)} and {np.shape(self.density_kg_m3)}"
            msg = f"snowpack: depth_m and density_kg_m3 must be (layer,) or (layer, range_line), got shapes {shapes}"
            raise ValueError(msg)
        depth_m, density = np.broadcast_arrays(depth_m, density)
        shape = depth_m.shape[:1]
        rough = {name: np.broadcast_to(np.asarray(getattr(self, name), dtype=float), shape) for name in ROUGH}
        bad = {
            "depth_m": ~np.isfinite(depth_m) | (np.diff(depth_m, axis=0, prepend=-np.inf) <= 0),
            "density_kg_m3": ~((density >= 0) & (density <= ICE_DENSITY_KG_M3)),
            "roughness_m": ~((rough["roughness_m"] >= 0) & np.isfinite(rough["roughness_m"])),
            "slope": ~((rough["slope"] > 0) & (rough["slope"] <= 1)),
            "attenuation_db_m": np.array([not 0 <= self.attenuation_db_m < np.inf]),
        }
        held = {"depth_m": depth_m, "density_kg_m3": density, **rough}
        for name, wrong in bad.items():
            if wrong.any():
                values = np.atleast_1d(held.get(name, self.attenuation_db_m))
                msg = f"snowpack: {name} must be {MUST[name]}, got {values[wrong][0]:g} at layer {np.argwhere(wrong)[0][0]}"
                raise ValueError(msg)
        for name, values in held.items():
            object.__setattr__(self, name, values)

    @property
    def shape(self):
        """(layer, range_line)."""
        return self.depth_m.shape


ROUGH = ("roughness_m", "slope")
MUST = {
    "depth_m": "finite and increase with layer",
    "density_kg_m3": f"in [0, {ICE_DENSITY_KG_M3:g}]",
    "roughness_m": "finite and not negative",
    "slope": "in (0, 1]",
    "attenuation_db_m": "finite and not negative",
}


@dataclass(frozen=True, kw_only=True)
class Climate:
    """What annual layers of dry snow are drawn from: `draw`.

    Depth and mean density follow Herron & Langway (1980). `accumulation_m` [m w.e. / yr]; `variability`, of its
    logarithm from year to year: cores, 0.17-0.28; `n_years` of layers; `temperature_k`: annual mean, Summit of Greenland
    by default; near-surface `density_sd_kg_m3` about the mean: cores, 18-39. Undulations as the reference flight's.
    """

    accumulation_m: float
    variability: float = 0.2
    n_years: int = 20
    temperature_k: float = 243.0
    surface_density_kg_m3: float = 340.0
    density_sd_kg_m3: float = 30.0
    drift_sd: float = 0.1  # of the logarithm of a year's accumulation from place to place
    drift_length_m: float = 3000.0
    density_length_m: float = 900.0
    roughness_m: float = 0.02
    slope: float = 0.03

    def draw(self, n_range_lines, line_spacing_m, *, rng):
        """`Snowpack` of `n_years` annual layers below a flat surface; ValueError where the firn has no such climate."""
        if not (self.n_years >= 1 and min(self.variability, self.drift_sd, self.density_sd_kg_m3) >= 0):
            msg = f"climate: n_years must be at least 1 and spreads not negative, got {self}"
            raise ValueError(msg)
        firn = (self.accumulation_m, self.temperature_k, self.surface_density_kg_m3)
        year = self.variability * rng.standard_normal((self.n_years, 1))
        drift = draw_along_track(self.n_years, n_range_lines, self.drift_length_m / line_spacing_m, rng=rng)
        spread = np.hypot(self.variability, self.drift_sd)
        water_m = self.accumulation_m * np.exp(year + self.drift_sd * drift - spread**2 / 2)
        water_m = np.concatenate([np.zeros((1, n_range_lines)), np.cumsum(water_m, axis=0)])
        middle_m = np.concatenate([(water_m[:-1] + water_m[1:]) / 2, water_m[-1:]])
        share = density_herron_langway80(middle_m, *firn) / ICE_DENSITY_KG_M3
        length = self.density_length_m / line_spacing_m
        anomaly = draw_along_track(self.n_years + 1, n_range_lines, length, rng=rng)
        # In logits: near the surface of the s.d. asked for, never below nothing or above ice.
        width = self.density_sd_kg_m3 / ICE_DENSITY_KG_M3 / (share[:1] * (1 - share[:1]))
        density = ICE_DENSITY_KG_M3 / (1 + (1 - share) / share * np.exp(-width * anomaly))
        return Snowpack(depth_herron_langway80(water_m, *firn), density, self.roughness_m, self.slope)
