"""Range checks of settings: one line that names the key, what must hold and what came."""


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
    """Name of a group of settings in the configuration: `climate` for `ClimateSettings`, `picks` for `PickSettings`."""
    return {"PickSettings": "picks"}.get(type(settings).__name__, type(settings).__name__[: -len("Settings")].lower())


def _number(settings, name):
    """Value of a setting; ValueError unless it is a number."""
    value = getattr(settings, name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        msg = f"{group_name(settings)}.{name} must be a number, got {value!r}"
        raise ValueError(msg)
    return value
