"""All settings of the synthetic reference flight, from one section of a configuration."""

import math
from dataclasses import dataclass, field, fields, is_dataclass, replace

from reference.line import line_length_km, place_at
from snowsim.constants import ICE_DENSITY_KG_M3, PROCESSED_BANDWIDTH_HZ
from snowsim.echogram import ROWS_BELOW_LAST_LAYER
from snowsim.limits import check_values
from snowsim.settings import Checked, setting
from snowsim.snowpack.firn import depth_herron_langway80, travel_time_s

DENSEST_SURFACE_KG_M3 = 540.0  # below 550, where the first stage of Herron & Langway (1980) ends


def limited(default, low=None, high=None, about=""):
    """A number with its default and its least and greatest value; without limits it is positive."""
    if low is None:
        return setting(default, about, low=0, above=True)
    return setting(default, about, low=low, high=high)


@dataclass(frozen=True)
class ClimateSettings(Checked):
    """Accumulation along the line. Every spread is a standard deviation of its logarithm."""

    group = "climate."

    # Below 0.5 a window would hold more years than are drawn; above 3 years would be thicker than
    # anywhere on the ice sheet.
    accumulation_factor: float = limited(
        0.85,
        0.5,
        3,
        "[1] times the mean accumulation of the line, 0.20-0.55 m w.e.; frames of 2012: .18 +- .05",
    )
    anomaly_sd: float = limited(
        0.18, 0, 1, "[1, of log] anomalies from year to year, shared along the flight"
    )
    undulation_sd: float = limited(
        0.07, 0, 1, "[1, of log] undulations, which stay in place from year to year"
    )
    undulation_min_km: float = limited(3.0, about="[km] shortest wavelength of undulations")
    undulation_max_km: float = limited(20.0, about="[km] longest wavelength of undulations")
    drift_sd: float = limited(
        0.085, 0, 1, "[1, of log] accumulation of one year from place to place"
    )
    drift_length_m: float = limited(3000.0, about="[m] correlation length of drift")
    relief_sd: float = limited(0.045, 0, 1, "[1, of log] wind relief, filled by the year above")
    relief_length_m: float = limited(45.0, about="[m] correlation length of relief")
    open_year: float = limited(
        0.8, 0.05, 1, "[years] of accumulation above the youngest autumn horizon"
    )

    def __post_init__(self):
        super().__post_init__()
        least_km = self.undulation_min_km
        check_values("climate.undulation_max_km", self.undulation_max_km, least_km, above=True)


@dataclass(frozen=True)
class FirnSettings(Checked):
    """Density steps in the firn. Every spread is a standard deviation of their logarithm."""

    group = "firn."

    surface_density_kg_m3: float = limited(
        340.0, 50, DENSEST_SURFACE_KG_M3, "[kg m-3] near-surface logs: 310-370"
    )
    horizon_jump_kg_m3: float = limited(
        160.0, 0, ICE_DENSITY_KG_M3, "[kg m-3] median density step of an autumn horizon"
    )
    horizon_year_sd: float = limited(0.42, 0, 3, "[1, of log] horizon's step from year to year")
    horizon_local_sd: float = limited(0.3, 0, 3, "[1, of log] horizon's step from place to place")
    local_length_m: float = limited(900.0, about="[m] correlation length from place to place")
    crusts_per_year: float = limited(
        1.2, 0, 20, "[per year] wind and melt crusts between horizons, which look like horizons"
    )
    crust_jump_kg_m3: float = limited(
        40.0, 0, ICE_DENSITY_KG_M3, "[kg m-3] median density step of a crust"
    )
    crust_sd: float = limited(0.45, 0, 3, "[1, of log] spread of a crust's step")
    layering_sd_kg_m3: float = limited(
        50.0, 0, ICE_DENSITY_KG_M3, "[kg m-3] detrended near-surface logs: 46-56"
    )
    layering_length_m: float = limited(0.0225, about="[m] vertical 1/e length, logs: 0.022-0.025")
    layering_lateral_m: float = limited(1.6, about="[m] lateral correlation length")
    layering_fade_m: float = limited(
        60.0, about="[m] depth over which the layering falls to 1/e, deeper than horizons"
    )
    fade_least_m: float = limited(0.9, about="[m] least depth over which density steps fall to 1/e")
    fade_depth_m: float = setting(
        2.4, "[m] its median: 47 % of test scenes then have fewer than 6 layers; paper: 57 %"
    )
    fade_sd: float = limited(1.2, 0, 3, "[1, of log] spread of that depth from place to place")
    percolation_elevation_m: float = setting(
        1800.0, "[m] elevation at which percolation has half its effect"
    )
    percolation_width_m: float = limited(
        60.0, about="[m] difference of elevation over which percolation sets in"
    )
    percolation_gap_share: float = limited(
        0.5, 0, 1, "[1] share of a horizon that percolation breaks"
    )
    percolation_blur_m: float = limited(0.06, 0, 1, "[m] spread of a horizon within one footprint")
    lens_jump_kg_m3: float = limited(
        180.0, 0, ICE_DENSITY_KG_M3, "[kg m-3] density step of an ice lens"
    )
    lens_length_m: float = limited(50.0, about="[m] median length of an ice lens")
    lenses_per_km_m: float = limited(
        4.0, 0, 20, "[per km of track and m of depth] number of lenses"
    )

    def __post_init__(self):
        super().__post_init__()
        check_values("firn.fade_depth_m", self.fade_depth_m, self.fade_least_m, above=True)
        # Snow as dense as the surface, with the step added, is no denser than ice.
        most = ICE_DENSITY_KG_M3 - self.surface_density_kg_m3
        for name in ("horizon_jump_kg_m3", "crust_jump_kg_m3", "lens_jump_kg_m3"):
            check_values(f"firn.{name} on snow of the surface", getattr(self, name), high=most)


@dataclass(frozen=True)
class RadarSettings(Checked):
    """The instrument, the aircraft and the product."""

    group = "radar."

    bin_size_s: float = limited(2.886e-10, about="[s] two-way; 4.33 cm in air, 2012 product")
    line_spacing_m: float = limited(
        5.2,
        about="[m] 4 presums x 4 coherent x 5 incoherent averages at 2 kHz and 130 m/s: 2012 sheet",
    )
    n_range_bins: int = setting(800, "[range bins] of a frame", low=200)
    surface_bin: int = setting(100, "[range bin] of the surface in a frame", low=10)
    n_sub_bins: int = setting(4, "[per range bin] scatterers in one look", low=1)
    n_looks: int = setting(5, "[looks] of a range line: 20 range lines have 100", low=1)
    bandwidth_hz: float = limited(
        PROCESSED_BANDWIDTH_HZ,
        1e8,
        2e10,
        about="[Hz] processed, 2.30016 to 7.449984 GHz, 2012 sheet; nominal sweep, paper: 6.0e+9",
    )
    response_widening: float = limited(
        1.15, 1, 3, "[1] of the range response over that of a Hann window on the band: sea ice 2016"
    )
    height_m: float = limited(500.0, about="[m] of the antenna over the snow")
    beamwidth_deg: float = limited(
        40.0, 1, 180, "[degrees] of one antenna, between its 3 dB points"
    )
    surface_slope: float = limited(0.022, 0.005, 1, "[1] rms slope of the snow surface")
    horizon_slope: float = limited(0.029, 0.005, 1, "[1] rms slope of buried horizons")
    diffuse_share: float = limited(
        0.0007, 0, 1, "[1] share of backscatter that follows the cosine of the angle"
    )
    roughness_m: float = limited(0.02, 0, 0.2, "[m] spread of an interface within one footprint")
    attenuation_db_m: float = limited(0.2, 0, 10, "[dB per m] two-way")
    surface_to_noise_db: float = limited(27.0, 0, 80, "[dB] mean surface peak over noise")
    sensitivity_sd_db: float = limited(
        2.0, 0, 10, "[dB] spread of surface_to_noise_db from place to place"
    )
    surface_sd_db: float = limited(1.0, 0, 10, "[dB] spread of the surface's echo along track")
    jitter_m: float = limited(
        0.4, 0, 10, "[m] movement of the aircraft, which is compensated in whole bins"
    )
    tracking_sd_bins: float = limited(0.8, 0, 5, "[range bins] slow error of that compensation")
    roll_enter: float = limited(
        0.0005,
        0,
        1,
        "[per range line] probability that a roll fade begins: a two-state Markov chain",
    )
    roll_leave: float = limited(0.005, 0, 1, "[per range line] probability that a roll fade ends")
    roll_gain: float = limited(0.7, about="[1] factor of power during a roll fade")
    sidelobe_db: float = limited(
        -34.0,
        -200,
        0,
        "[dB] pedestal of imperfect deconvolution at zero delay, relative to an echo: sea ice 2016",
    )
    sidelobe_fall_s: float = limited(
        1.8e-09, about="[s] two-way delay over which the pedestal falls to 1/e: sea ice 2016"
    )
    band_spacing_s: float = limited(
        2.5e-8, about="[s] mean distance of horizontal bands of coherent noise: sea ice 2016"
    )
    band_noise_db: float = limited(
        -4.0, -200, 20, "[dB] mean power of bands over thermal noise: sea ice 2016"
    )
    band_width_s: float = limited(
        5e-10, about="[s] standard deviation of a band's shape: sea ice 2016"
    )
    line_gain_sd_db: float = limited(
        0.4, 0, 3, "[dB] spread of gain from range line to range line: sea ice 2016"
    )
    quantisation_db: float = limited(
        0.25,
        0,
        3,
        "[dB] step of stored power: grey level of the pictures of 2016 and 2017; 0: none",
    )
    jump_rate: float = limited(0.0001, 0, 1, "[per range line] probability of a brightness jump")
    jump_sd_db: float = limited(1.0, 0, 10, "[dB] standard deviation of brightness jumps")
    saturated_rate: float = limited(
        0.0002, 0, 1, "[per range line] probability of an overloaded receiver"
    )
    missing_rate: float = limited(0.0002, 0, 1, "[per range line] probability of no echo")

    @property
    def sub_bin_s(self):
        """Spacing [s] of the grid on which echoes are drawn."""
        return self.bin_size_s / self.n_sub_bins

    def __post_init__(self):
        super().__post_init__()
        most = self.n_range_bins - 100
        check_values("radar.surface_bin with 100 rows below it", self.surface_bin, high=most)
        # Samples 1 / bandwidth apart are the coarsest that hold the response of the sweep.
        least = self.bin_size_s * self.bandwidth_hz
        check_values("radar.n_sub_bins that sample the sweep", self.n_sub_bins, least)


@dataclass(frozen=True)
class PickSettings(Checked):
    """Annotation: which layers can be seen, and which the picker finds."""

    group = "picks."

    visible_db: float = limited(
        1.0, 0, 30, "[dB] truth ends where horizons rise less than this over the snow above them"
    )
    picker_db: float = limited(
        1.3, 0, 30, "[dB] the semi-automatic picker loses a layer that rises less than this"
    )
    picker_lines: int = limited(9, 1, 200, "[range lines] that the picker averages")
    shortest_run: int = limited(
        16, 1, 200, "[range lines] pieces of a layer shorter than this are not picked"
    )
    wrong_share: float = limited(
        0.03, 0, 1, "[1] of pieces behind a gap that follow the layer above or below: 2 % of picks"
    )


@dataclass(frozen=True)
class Settings:
    """All settings of the reference flight, by group."""

    climate: ClimateSettings = field(default_factory=ClimateSettings)
    firn: FirnSettings = field(default_factory=FirnSettings)
    radar: RadarSettings = field(default_factory=RadarSettings)
    picks: PickSettings = field(default_factory=PickSettings)


# A profile never changes: other values get another name.
PROFILES = {"greenland_2012": Settings()}


def replaced(settings, values, where=""):
    """Settings with some values replaced, a dict by name; a group of settings is a dict in it.

    ValueError, naming the setting, if one is unknown or not within its limits.
    """
    if not isinstance(values, dict):
        msg = f"{where.rstrip('.') or 'settings'}: expected names with values, got {values!r}"
        raise ValueError(msg)
    known = [each.name for each in fields(settings)]
    changes = {}
    for name, value in values.items():
        if name not in known:
            msg = f"{where}{name}: unknown key, expected some of {', '.join(known)}"
            raise ValueError(msg)
        group = getattr(settings, name)
        if is_dataclass(group):
            value = replaced(group, value, f"{where}{name}.")
        changes[name] = value
    return replace(settings, **changes)


def checked_settings(reference):
    """Settings from the section `reference` of a configuration, a dict of dicts.

    Its keys are `climate`, `firn`, `radar` and `picks`; what is missing keeps its default.
    ValueError, naming the key, if one is unknown or a value is out of range.
    """
    settings = replaced(Settings(), reference)
    # The default's window is large enough (tested), and its check imports an interpolator slowly.
    if settings != Settings():
        check_window(settings)
    return settings


def check_window(settings):
    """ValueError unless the window holds the youngest horizon at its deepest, and rows below it."""
    climate, radar = settings.climate, settings.radar
    # Accumulation is largest at the end of the line.
    wettest = place_at(line_length_km(), climate.accumulation_factor)
    water_m = climate.open_year * wettest.accumulation_m
    density = settings.firn.surface_density_kg_m3
    depth_m = depth_herron_langway80(
        water_m, wettest.accumulation_m, wettest.temperature_k, density
    )
    bins = float(travel_time_s(depth_m, water_m)) / radar.bin_size_s
    least = radar.surface_bin + math.ceil(bins) + ROWS_BELOW_LAST_LAYER
    what = (
        f"radar.n_range_bins (surface in row {radar.surface_bin}, first year of up to "
        f"{bins:.0f} bins, {ROWS_BELOW_LAST_LAYER} rows below)"
    )
    check_values(what, radar.n_range_bins, least)
