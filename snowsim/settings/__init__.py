"""Settings as fields of dataclasses, each with its default, its limits, its unit and its meaning.

Limits have the names that JSON Schema gives them. The modules beside this one hold the settings and
recipes of one stage each. Every start of the workflow imports them, so they import no stage.
"""

import math
from dataclasses import field, fields, is_dataclass, replace
from typing import get_args

WORDS = {
    "minimum": "of at least",
    "exclusiveMinimum": "above",
    "maximum": "of at most",
    "exclusiveMaximum": "below",
}


def setting(default, about, **limits):
    """A setting with its default, `[unit] meaning, source`, and limits named as in JSON Schema."""
    return field(default=default, metadata={"about": about, **limits})


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


class Checked:
    """Base of dataclasses of settings, which are checked when they are made.

    ValueError, naming the setting in its `group`, unless each has the right type and is within its
    limits.
    """

    group = ""

    def __post_init__(self):
        for each in fields(self):
            value = getattr(self, each.name)
            if value is None and type(None) in get_args(each.type):
                continue
            expected = _expected(value, each)
            if expected:
                msg = f"{self.group}{each.name} must {expected}, got {value!r}"
                raise ValueError(msg)


def _expected(value, each):
    """What the value of a field must be, in words; None if it is valid."""
    limits = each.metadata
    kinds = get_args(each.type) or (each.type,)
    if "enum" in limits:
        return None if value in limits["enum"] else f"be one of {', '.join(limits['enum'])}"
    if bool in kinds:
        return None if isinstance(value, bool) else "be true or false"
    if tuple in kinds:
        return None if _is_list(value, limits) else f"be {limits['listed']}"
    if int not in kinds and float not in kinds:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float):
        return "be a number"
    is_kind = isinstance(value, int) or int not in kinds
    if is_kind and math.isfinite(value) and _is_within(value, limits):
        return None
    if limits.get("exclusiveMinimum") == 0 and "exclusiveMaximum" not in limits:
        return "be positive and finite"
    if "minimum" in limits and "maximum" in limits:
        return f"lie in [{limits['minimum']:g}, {limits['maximum']:g}]"
    bounds = [f"{words} {limits[name]:g}" for name, words in WORDS.items() if name in limits]
    kind = "an integer" if int in kinds else "a finite number"
    return f"be {kind} {' and '.join(bounds)}".rstrip()


def _is_list(value, limits):
    """Whether a value is a list of numbers that keeps the limits of its length and its numbers."""
    if not isinstance(value, list | tuple):
        return False
    if not limits["minItems"] <= len(value) <= limits.get("maxItems", math.inf):
        return False
    return all(isinstance(each, int | float) and _is_within(each, limits) for each in value)


def _is_within(value, limits):
    if not limits.get("minimum", -math.inf) <= value <= limits.get("maximum", math.inf):
        return False
    above = limits.get("exclusiveMinimum", -math.inf)
    return above < value < limits.get("exclusiveMaximum", math.inf)
