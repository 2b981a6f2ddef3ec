"""Settings as fields of dataclasses: default, limits, and unit, meaning and source, each once.

Limits are keywords of JSON Schema: the schema of the configuration is made from them.
"""

import math
from dataclasses import field, fields
from typing import get_args

WORDS = {
    "minimum": "of at least",
    "exclusiveMinimum": "above",
    "maximum": "of at most",
    "exclusiveMaximum": "below",
}


def setting(default, about, **limits):
    """A setting with its default, `[unit] meaning, source`, and what JSON Schema says limits it."""
    return field(default=default, metadata={"about": about, **limits})


def limited(default, low=None, high=None, about=""):
    """A number with its default and its limits; without any it is positive."""
    if low is None:
        return setting(default, about, exclusiveMinimum=0)
    return setting(default, about, minimum=low, maximum=high)


def check_settings(settings, group=""):
    """ValueError, naming the setting, unless each is of its kind and within its limits."""
    for each in fields(settings):
        value = getattr(settings, each.name)
        if value is None and type(None) in get_args(each.type):
            continue
        expected = _expected(value, each)
        if expected:
            msg = f"{group}{each.name} must {expected}, got {value!r}"
            raise ValueError(msg)


def _expected(value, each):
    """What a value had to be, in words; None if it is that."""
    limits = each.metadata
    kinds = get_args(each.type) or (each.type,)
    if "enum" in limits:
        return None if value in limits["enum"] else f"be one of {', '.join(limits['enum'])}"
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
    said = [f"{words} {limits[name]:g}" for name, words in WORDS.items() if name in limits]
    return f"be {'an integer' if int in kinds else 'a finite number'} {' and '.join(said)}".rstrip()


def _is_within(value, limits):
    if not limits.get("minimum", -math.inf) <= value <= limits.get("maximum", math.inf):
        return False
    above = limits.get("exclusiveMinimum", -math.inf)
    return above < value < limits.get("exclusiveMaximum", math.inf)
