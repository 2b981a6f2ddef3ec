"""Settings as fields of dataclasses, each with its default, its limits, its unit and its meaning.

The modules beside this one hold the settings and recipes of one stage each. Every start of the
workflow imports them, so they import no stage.
"""

from dataclasses import field, fields
from types import NoneType
from typing import get_args

from snowsim.echogram import check_choice
from snowsim.limits import check_count, check_values


def setting(default, about, **limits):
    """A setting with its default, `[unit] meaning, source`, and its limits.

    Limits of a number are those of `check_values`; those of a word are its `choices`.
    """
    return field(default=default, metadata={"about": about, "limits": limits})


class Checked:
    """Base of dataclasses of settings, which are checked when they are made.

    ValueError, naming the setting in its `group`, unless each has the right type and is within its
    limits.
    """

    group = ""

    def __post_init__(self):
        for each in fields(self):
            _check(f"{self.group}{each.name}", getattr(self, each.name), each)


def _check(name, value, each):
    """Refuse a value that has another type than a field, or is not within its limits."""
    limits = each.metadata["limits"]
    kinds = get_args(each.type) or (each.type,)
    if value is None and NoneType in kinds:
        return
    if str in kinds:
        check_choice(name, value, limits["choices"])
    elif bool in kinds:
        if not isinstance(value, bool):
            msg = f"{name} must be true or false, got {value!r}"
            raise ValueError(msg)
    elif tuple in kinds:
        if not isinstance(value, list | tuple) or len(value) == 0:
            msg = f"{name} must be a list of one number or more, got {value!r}"
            raise ValueError(msg)
        for number in value:
            check_values(name, number, **limits, number=True)
    else:
        if int in kinds:
            check_count(name, value, limits["low"])
        check_values(name, value, **limits, number=True)
