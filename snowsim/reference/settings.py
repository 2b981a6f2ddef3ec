"""All settings of the synthetic reference flight from one section of a configuration."""

import math
from dataclasses import dataclass, field, fields

from snowsim.echogram import ROWS_BELOW_LAST_LAYER
from snowsim.reference.firn import depth_herron_langway80, travel_time_s
from snowsim.reference.groups import ClimateSettings, FirnSettings, PickSettings, RadarSettings
from snowsim.reference.line import line_length_km, place_at


@dataclass(frozen=True)
class Settings:
    """All settings of the reference flight, by group."""

    climate: ClimateSettings = field(default_factory=ClimateSettings)
    firn: FirnSettings = field(default_factory=FirnSettings)
    radar: RadarSettings = field(default_factory=RadarSettings)
    picks: PickSettings = field(default_factory=PickSettings)


GROUPS = {"climate": ClimateSettings, "firn": FirnSettings, "radar": RadarSettings, "picks": PickSettings}


def checked_settings(reference):
    """Settings of the reference flight from the `reference` section of a configuration.

    Parameters
    ----------
    reference : dict of dict
        Groups `climate`, `firn`, `radar`, `picks`; what is left out keeps its default.

    Returns
    -------
    Settings

    Raises
    ------
    ValueError
        Naming the key, if a group or a key is unknown or a value is out of range.
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
        msg = (
            f"radar.n_range_bins must be at least {least}, the surface's row {radar.surface_bin}, a first year of up "
            f"to {bins:.0f} bins and {ROWS_BELOW_LAST_LAYER} rows below it, got {radar.n_range_bins}"
        )
        raise ValueError(msg)


def _refuse_unknown(given, known, where):
    unknown = sorted(set(given) - set(known))
    if unknown:
        msg = f"{where}: unknown key {unknown[0]}, expected some of {', '.join(known)}"
        raise ValueError(msg)
