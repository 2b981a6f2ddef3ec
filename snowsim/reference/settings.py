"""All settings of the synthetic reference flight from one section of a configuration."""

from dataclasses import dataclass, field, fields

from snowsim.reference.groups import ClimateSettings, FirnSettings, PickSettings, RadarSettings


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
    return Settings(**made)


def _refuse_unknown(given, known, where):
    unknown = sorted(set(given) - set(known))
    if unknown:
        msg = f"{where}: unknown key {unknown[0]}, expected some of {', '.join(known)}"
        raise ValueError(msg)
