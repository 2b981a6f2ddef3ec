"""All settings of the synthetic reference flight, from one section of a configuration."""

import math
from dataclasses import dataclass, field, fields

from snowsim.constants import ICE_DENSITY_KG_M3, PROCESSED_BANDWIDTH_HZ
from snowsim.echogram import ROWS_BELOW_LAST_LAYER, check_choice
from snowsim.reference.firn import depth_herron_langway80, travel_time_s
from snowsim.reference.line import line_length_km, place_at

DENSEST_SURFACE_KG_M3 = 540.0  # below 550, where the first stage of Herron & Langway (1980) ends


def limited(default, low=None, high=None):
    """A setting with its default and its limits; without any it is positive and finite."""
    return field(default=default, metadata={"limits": (low, high)})


def check_limits(settings):
    """ValueError unless every limited setting of a group is a number within its limits."""
    for each in fields(settings):
        if "limits" not in each.metadata:
            continue
        value = getattr(settings, each.name)
        low, high = each.metadata["limits"]
        if isinstance(value, bool) or not isinstance(value, int | float):
            problem = f"be a number, got {value!r}"
        elif low is None and not 0 < value < math.inf:
            problem = f"be positive and finite, got {value}"
        elif low is not None and not low <= value <= high:
            problem = f"lie in [{low:g}, {high:g}], got {value}"
        else:
            continue
        group = next(name for name, group in GROUPS.items() if group is type(settings))
        msg = f"{group}.{each.name} must {problem}"
        raise ValueError(msg)


@dataclass(frozen=True)
class ClimateSettings:
    """Accumulation along the line; spreads are standard deviations of its logarithm."""

    # Below half, a window holds more years than a climate has; above three, years are thicker than
    # anywhere there.
    accumulation_factor: float = limited(0.85, 0.5, 3)
    anomaly_sd: float = limited(0.18, 0, 1)
    undulation_sd: float = limited(0.07, 0, 1)
    undulation_min_km: float = limited(3.0)
    undulation_max_km: float = limited(20.0)
    drift_sd: float = limited(0.085, 0, 1)
    drift_length_m: float = limited(3000.0)
    relief_sd: float = limited(0.045, 0, 1)
    relief_length_m: float = limited(45.0)
    open_year: float = limited(0.8, 0.05, 1)

    def __post_init__(self):
        check_limits(self)
        if self.undulation_max_km <= self.undulation_min_km:
            msg = "climate.undulation_max_km must exceed undulation_min_km, "
            msg += f"got {self.undulation_max_km:g}"
            raise ValueError(msg)


@dataclass(frozen=True)
class FirnSettings:
    """Density contrasts in the firn; spreads are standard deviations of their logarithm."""

    surface_density_kg_m3: float = limited(340.0, 50, DENSEST_SURFACE_KG_M3)
    horizon_jump_kg_m3: float = limited(160.0, 0, ICE_DENSITY_KG_M3)
    horizon_year_sd: float = limited(0.42, 0, 3)
    horizon_local_sd: float = limited(0.3, 0, 3)
    local_length_m: float = limited(900.0)
    crusts_per_year: float = limited(1.2, 0, 20)
    crust_jump_kg_m3: float = limited(40.0, 0, ICE_DENSITY_KG_M3)
    crust_sd: float = limited(0.45, 0, 3)
    layering_sd_kg_m3: float = limited(50.0, 0, ICE_DENSITY_KG_M3)
    layering_length_m: float = limited(0.0225)
    layering_lateral_m: float = limited(1.6)
    layering_fade_m: float = limited(60.0)
    fade_least_m: float = limited(0.9)
    fade_depth_m: float = 2.4
    fade_sd: float = limited(1.2, 0, 3)
    percolation_elevation_m: float = 1800.0
    percolation_width_m: float = limited(60.0)
    percolation_gap_share: float = limited(0.5, 0, 1)
    percolation_blur_m: float = limited(0.06, 0, 1)
    lens_jump_kg_m3: float = limited(180.0, 0, ICE_DENSITY_KG_M3)
    lens_length_m: float = limited(50.0)
    lenses_per_km_m: float = limited(4.0, 0, 20)

    def __post_init__(self):
        check_limits(self)
        if not self.fade_least_m < self.fade_depth_m < math.inf:
            msg = f"firn.fade_depth_m must exceed fade_least_m {self.fade_least_m:g}, "
            msg += f"got {self.fade_depth_m}"
            raise ValueError(msg)
        most = ICE_DENSITY_KG_M3 - self.surface_density_kg_m3
        for name in ("horizon_jump_kg_m3", "crust_jump_kg_m3", "lens_jump_kg_m3"):
            jump = getattr(self, name)
            if jump > most:
                msg = f"firn.{name} must be at most {most:g}: snow of the surface's density plus "
                msg += f"the step is no denser than ice, got {jump:g}"
                raise ValueError(msg)


@dataclass(frozen=True)
class RadarSettings:
    """The instrument, the aircraft and the product."""

    bin_size_s: float = limited(2.886e-10)
    line_spacing_m: float = limited(5.2)
    n_range_bins: int = 800
    surface_bin: int = 100
    n_sub_bins: int = 4
    n_looks: int = 5
    bandwidth_hz: float = limited(PROCESSED_BANDWIDTH_HZ)
    response_widening: float = limited(1.15, 1, 3)
    height_m: float = limited(500.0)
    beamwidth_deg: float = limited(40.0, 1, 180)
    surface_slope: float = limited(0.022, 0.005, 1)
    horizon_slope: float = limited(0.029, 0.005, 1)
    diffuse_share: float = limited(0.0007, 0, 1)
    roughness_m: float = limited(0.02, 0, 0.2)
    attenuation_db_m: float = limited(0.2, 0, 10)
    surface_to_noise_db: float = limited(27.0, 0, 80)
    sensitivity_sd_db: float = limited(2.0, 0, 10)
    surface_sd_db: float = limited(1.0, 0, 10)
    jitter_m: float = limited(0.4, 0, 10)
    tracking_sd_bins: float = limited(0.8, 0, 5)
    roll_enter: float = limited(0.0005, 0, 1)
    roll_leave: float = limited(0.005, 0, 1)
    roll_gain: float = limited(0.7)
    sidelobe_db: float = limited(-34.0, -200, 0)
    sidelobe_fall_s: float = limited(1.8e-09)
    band_spacing_s: float = limited(2.5e-8)
    band_noise_db: float = limited(-4.0, -200, 20)
    band_width_s: float = limited(5e-10)
    line_gain_sd_db: float = limited(0.4, 0, 3)
    quantisation_db: float = limited(0.25, 0, 3)
    jump_rate: float = limited(0.0001, 0, 1)
    jump_sd_db: float = limited(1.0, 0, 10)
    saturated_rate: float = limited(0.0002, 0, 1)
    missing_rate: float = limited(0.0002, 0, 1)

    @property
    def sub_bin_s(self):
        """Spacing of the grid on which echoes are drawn [s]."""
        return self.bin_size_s / self.n_sub_bins

    def __post_init__(self):
        check_limits(self)
        least_of = {"n_range_bins": 200, "surface_bin": 10, "n_sub_bins": 1, "n_looks": 1}
        for name, least in least_of.items():
            value = getattr(self, name)
            if not isinstance(value, int) or value < least:
                msg = f"radar.{name} must be an integer of at least {least}, got {value!r}"
                raise ValueError(msg)
        if self.surface_bin > self.n_range_bins - 100:
            msg = f"radar.surface_bin must leave 100 of {self.n_range_bins} rows below it, "
            msg += f"got {self.surface_bin}"
            raise ValueError(msg)
        # A sample every 1 / bandwidth is the coarsest that holds the response of the sweep.
        if self.sub_bin_s > 1 / self.bandwidth_hz:
            least = self.bin_size_s * self.bandwidth_hz
            msg = f"radar.n_sub_bins must be at least {least:.2f} to sample "
            msg += f"{self.bandwidth_hz:g} Hz, got {self.n_sub_bins}"
            raise ValueError(msg)


@dataclass(frozen=True)
class PickSettings:
    """Annotation: what can be seen, and what the picker finds."""

    visible_db: float = limited(1.0, 0, 30)
    gap_db: float = limited(0.2, 0, 30)
    picker_db: float = limited(1.3, 0, 30)
    picker_lines: int = limited(9, 1, 200)
    shortest_run: int = limited(16, 1, 200)
    wrong_share: float = limited(0.03, 0, 1)
    of_flight: str = "picker"

    def __post_init__(self):
        check_limits(self)
        check_choice("picks.of_flight", self.of_flight, ("picker", "oracle"))


@dataclass(frozen=True)
class Settings:
    """All settings of the reference flight, by group."""

    climate: ClimateSettings = field(default_factory=ClimateSettings)
    firn: FirnSettings = field(default_factory=FirnSettings)
    radar: RadarSettings = field(default_factory=RadarSettings)
    picks: PickSettings = field(default_factory=PickSettings)


GROUPS = {group.name: group.default_factory for group in fields(Settings)}


def checked_settings(reference):
    """Settings from the `reference` section of a configuration.

    That has dicts `climate`, `firn`, `radar`, `picks`. Missing keys keep their defaults.
    ValueError, naming the key, if one is unknown or a value out of range.
    """
    _refuse_unknown(reference, GROUPS, "reference")
    made = {}
    for name, group in GROUPS.items():
        given = reference.get(name, {})
        _refuse_unknown(given, [f.name for f in fields(group)], f"reference.{name}")
        made[name] = group(**given)
    settings = Settings(**made)
    if settings != Settings():
        check_window(settings)
    return settings


def check_window(settings):
    """ValueError unless the window holds the first year's horizon at its deepest, and room."""
    climate, radar = settings.climate, settings.radar
    wettest = place_at(line_length_km(), climate.accumulation_factor)
    water_m = climate.open_year * wettest.accumulation_m
    density = settings.firn.surface_density_kg_m3
    depth_m = depth_herron_langway80(
        water_m, wettest.accumulation_m, wettest.temperature_k, density
    )
    bins = float(travel_time_s(depth_m, water_m)) / radar.bin_size_s
    least = radar.surface_bin + math.ceil(bins) + ROWS_BELOW_LAST_LAYER
    if radar.n_range_bins < least:
        msg = f"radar.n_range_bins must be at least {least}, "
        msg += f"the surface's row {radar.surface_bin}, a first year of up to {bins:.0f} bins "
        msg += f"and {ROWS_BELOW_LAST_LAYER} rows below it, got {radar.n_range_bins}"
        raise ValueError(msg)


def _refuse_unknown(given, known, where):
    unknown = sorted(set(given) - set(known))
    if unknown:
        msg = f"{where}: unknown key {unknown[0]}, expected some of {', '.join(known)}"
        raise ValueError(msg)
