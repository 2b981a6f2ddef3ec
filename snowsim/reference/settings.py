"""All settings of the synthetic reference flight, from one section of a configuration, every value checked early."""

import math
from dataclasses import dataclass, field, fields

from snowsim.constants import ICE_DENSITY_KG_M3, PROCESSED_BANDWIDTH_HZ
from snowsim.echogram import ROWS_BELOW_LAST_LAYER
from snowsim.reference.firn import depth_herron_langway80, travel_time_s
from snowsim.reference.line import line_length_km, place_at

DENSEST_SURFACE_KG_M3 = 540.0  # below 550, where the first stage of Herron & Langway (1980) ends


def check_within(settings, low, high, *names):
    """Raise ValueError unless the named values lie in [low, high]; NaN does not."""
    for name in names:
        value = _number(settings, name)
        if not low <= value <= high:
            msg = f"{group_name(settings)}.{name} must lie in [{low:g}, {high:g}], got {value}"
            raise ValueError(msg)


def check_positive(settings, *names):
    """Raise ValueError unless the named values are positive and finite."""
    for name in names:
        value = _number(settings, name)
        if not 0 < value < float("inf"):
            msg = f"{group_name(settings)}.{name} must be positive and finite, got {value}"
            raise ValueError(msg)


def group_name(settings):
    """Name of a group in the configuration: `climate` for `ClimateSettings`, `picks` for `PickSettings`."""
    return {"PickSettings": "picks"}.get(type(settings).__name__, type(settings).__name__[: -len("Settings")].lower())


def _number(settings, name):
    """Value of a setting; ValueError unless it is a number."""
    value = getattr(settings, name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        msg = f"{group_name(settings)}.{name} must be a number, got {value!r}"
        raise ValueError(msg)
    return value


@dataclass(frozen=True)
class ClimateSettings:
    """Accumulation along the line; spreads are standard deviations of its logarithm."""

    accumulation_factor: float = 0.85
    anomaly_sd: float = 0.18
    undulation_sd: float = 0.07
    undulation_min_km: float = 3.0
    undulation_max_km: float = 20.0
    drift_sd: float = 0.085
    drift_length_m: float = 3000.0
    relief_sd: float = 0.045
    relief_length_m: float = 45.0
    open_year: float = 0.8

    def __post_init__(self):
        # Below half, a window holds more years than a climate has; above three, years are thicker than anywhere there.
        check_within(self, 0.5, 3, "accumulation_factor")
        check_within(self, 0, 1, "anomaly_sd", "undulation_sd", "drift_sd", "relief_sd")
        check_positive(self, "undulation_min_km", "undulation_max_km", "drift_length_m", "relief_length_m")
        check_within(self, 0.05, 1, "open_year")
        if self.undulation_max_km <= self.undulation_min_km:
            msg = f"climate.undulation_max_km must exceed undulation_min_km, got {self.undulation_max_km:g}"
            raise ValueError(msg)


@dataclass(frozen=True)
class FirnSettings:
    """Density contrasts in the firn; spreads are standard deviations of their logarithm."""

    surface_density_kg_m3: float = 340.0
    horizon_jump_kg_m3: float = 160.0
    horizon_year_sd: float = 0.42
    horizon_local_sd: float = 0.3
    local_length_m: float = 900.0
    crusts_per_year: float = 1.2
    crust_jump_kg_m3: float = 40.0
    crust_sd: float = 0.45
    layering_sd_kg_m3: float = 50.0
    layering_length_m: float = 0.0225
    layering_lateral_m: float = 1.6
    layering_fade_m: float = 60.0
    fade_least_m: float = 0.9
    fade_depth_m: float = 2.4
    fade_sd: float = 1.2
    percolation_elevation_m: float = 1800.0
    percolation_width_m: float = 60.0
    percolation_gap_share: float = 0.5
    percolation_blur_m: float = 0.06
    lens_jump_kg_m3: float = 180.0
    lens_length_m: float = 50.0
    lenses_per_km_m: float = 4.0

    def __post_init__(self):
        check_within(self, 50, DENSEST_SURFACE_KG_M3, "surface_density_kg_m3")
        check_within(self, 0, ICE_DENSITY_KG_M3, "horizon_jump_kg_m3", "crust_jump_kg_m3", "lens_jump_kg_m3")
        check_within(self, 0, ICE_DENSITY_KG_M3, "layering_sd_kg_m3")
        check_within(self, 0, 3, "horizon_year_sd", "horizon_local_sd", "crust_sd", "fade_sd")
        check_within(self, 0, 20, "crusts_per_year", "lenses_per_km_m")
        check_positive(self, "local_length_m", "layering_length_m", "layering_lateral_m", "layering_fade_m")
        check_positive(self, "fade_least_m", "lens_length_m")
        if not self.fade_least_m < self.fade_depth_m < float("inf"):
            msg = f"firn.fade_depth_m must exceed fade_least_m {self.fade_least_m:g}, got {self.fade_depth_m}"
            raise ValueError(msg)
        check_positive(self, "percolation_width_m")
        for name in ("horizon_jump_kg_m3", "crust_jump_kg_m3", "lens_jump_kg_m3"):
            if self.surface_density_kg_m3 + getattr(self, name) > ICE_DENSITY_KG_M3:
                most = ICE_DENSITY_KG_M3 - self.surface_density_kg_m3
                msg = f"firn.{name} must be at most {most:g}: snow of the surface's density plus the step is no denser "
                msg += f"than ice, got {getattr(self, name):g}"
                raise ValueError(msg)
        check_within(self, 0, 1, "percolation_gap_share", "percolation_blur_m")


@dataclass(frozen=True)
class RadarSettings:
    """The instrument, the aircraft and the product."""

    bin_size_s: float = 2.886e-10
    line_spacing_m: float = 5.2
    n_range_bins: int = 800
    surface_bin: int = 100
    n_sub_bins: int = 4
    n_looks: int = 5
    bandwidth_hz: float = PROCESSED_BANDWIDTH_HZ
    response_widening: float = 1.15
    height_m: float = 500.0
    beamwidth_deg: float = 40.0
    surface_slope: float = 0.022
    horizon_slope: float = 0.029
    diffuse_share: float = 0.0007
    roughness_m: float = 0.02
    attenuation_db_m: float = 0.2
    surface_to_noise_db: float = 27.0
    sensitivity_sd_db: float = 2.0
    surface_sd_db: float = 1.0
    jitter_m: float = 0.4
    tracking_sd_bins: float = 0.8
    roll_enter: float = 0.0005
    roll_leave: float = 0.005
    roll_gain: float = 0.7
    sidelobe_db: float = -34.0
    sidelobe_fall_s: float = 1.8e-09
    band_spacing_s: float = 2.5e-8
    band_noise_db: float = -4.0
    band_width_s: float = 5e-10
    line_gain_sd_db: float = 0.4
    quantisation_db: float = 0.25
    jump_rate: float = 0.0001
    jump_sd_db: float = 1.0
    saturated_rate: float = 0.0002
    missing_rate: float = 0.0002

    def __post_init__(self):
        check_positive(self, "bin_size_s", "line_spacing_m", "bandwidth_hz", "height_m", "roll_gain")
        check_positive(self, "sidelobe_fall_s", "band_spacing_s", "band_width_s")
        for name, least in (("n_range_bins", 200), ("surface_bin", 10), ("n_sub_bins", 1), ("n_looks", 1)):
            value = getattr(self, name)
            if not isinstance(value, int) or value < least:
                msg = f"radar.{name} must be an integer of at least {least}, got {value!r}"
                raise ValueError(msg)
        if self.surface_bin > self.n_range_bins - 100:
            msg = f"radar.surface_bin must leave 100 of {self.n_range_bins} rows below it, got {self.surface_bin}"
            raise ValueError(msg)
        # A sample every 1 / bandwidth is the coarsest that holds the response of the sweep.
        if self.bin_size_s / self.n_sub_bins > 1 / self.bandwidth_hz:
            msg = f"radar.n_sub_bins must be at least {self.bin_size_s * self.bandwidth_hz:.2f} to sample "
            msg += f"{self.bandwidth_hz:g} Hz, got {self.n_sub_bins}"
            raise ValueError(msg)
        check_within(self, 1, 3, "response_widening")
        check_within(self, 1, 180, "beamwidth_deg")
        check_within(self, 0.005, 1, "surface_slope", "horizon_slope")
        check_within(self, 0, 1, "diffuse_share", "roll_enter", "roll_leave")
        check_within(self, 0, 1, "jump_rate", "saturated_rate", "missing_rate")
        check_within(self, 0, 0.2, "roughness_m")
        check_within(self, 0, 10, "attenuation_db_m", "sensitivity_sd_db", "surface_sd_db", "jump_sd_db", "jitter_m")
        check_within(self, 0, 5, "tracking_sd_bins")
        check_within(self, 0, 80, "surface_to_noise_db")
        check_within(self, -200, 0, "sidelobe_db")
        check_within(self, -200, 20, "band_noise_db")
        check_within(self, 0, 3, "line_gain_sd_db", "quantisation_db")


@dataclass(frozen=True)
class PickSettings:
    """Annotation: what can be seen, and what the picker finds."""

    visible_db: float = 1.0
    gap_db: float = 0.2
    picker_db: float = 1.3
    picker_lines: int = 9
    shortest_run: int = 16

    def __post_init__(self):
        check_within(self, 0, 30, "visible_db", "gap_db", "picker_db")
        check_within(self, 1, 200, "picker_lines", "shortest_run")


@dataclass(frozen=True)
class Settings:
    """All settings of the reference flight, by group."""

    climate: ClimateSettings = field(default_factory=ClimateSettings)
    firn: FirnSettings = field(default_factory=FirnSettings)
    radar: RadarSettings = field(default_factory=RadarSettings)
    picks: PickSettings = field(default_factory=PickSettings)


GROUPS = {"climate": ClimateSettings, "firn": FirnSettings, "radar": RadarSettings, "picks": PickSettings}


def checked_settings(reference):
    """Settings from the `reference` section of a configuration: dicts `climate`, `firn`, `radar`, `picks`.

    Missing keys keep their defaults. ValueError, naming the key, if one is unknown or a value out of range.
    """
    _refuse_unknown(reference, GROUPS, "reference")
    made = {}
    for name, group in GROUPS.items():
        given = reference.get(name, {})
        _refuse_unknown(given, [f.name for f in fields(group)], f"reference.{name}")
        made[name] = group(**given)
    settings = Settings(**made)
    _check_window(settings)
    return settings


def _check_window(settings):
    """Raise ValueError unless the window holds the first year's horizon where it is deepest, and room below it."""
    climate, radar = settings.climate, settings.radar
    wettest = place_at(line_length_km(), climate.accumulation_factor)
    water_m = climate.open_year * wettest.accumulation_m
    density = settings.firn.surface_density_kg_m3
    depth_m = depth_herron_langway80(water_m, wettest.accumulation_m, wettest.temperature_k, density)
    bins = float(travel_time_s(depth_m, water_m)) / radar.bin_size_s
    least = radar.surface_bin + math.ceil(bins) + ROWS_BELOW_LAST_LAYER
    if radar.n_range_bins < least:
        msg = f"radar.n_range_bins must be at least {least}, the surface's row {radar.surface_bin}, a first year of up "
        msg += f"to {bins:.0f} bins and {ROWS_BELOW_LAST_LAYER} rows below it, got {radar.n_range_bins}"
        raise ValueError(msg)


def _refuse_unknown(given, known, where):
    unknown = sorted(set(given) - set(known))
    if unknown:
        msg = f"{where}: unknown key {unknown[0]}, expected some of {', '.join(known)}"
        raise ValueError(msg)
