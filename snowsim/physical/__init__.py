"""Radars and snow in physical units, and the terms of eq. (1) that they make."""

from snowsim.physical.echo import physical_parameters
from snowsim.physical.radar import PRESETS, Radar
from snowsim.physical.snowpack import Climate, Snowpack

__all__ = ["PRESETS", "Climate", "Radar", "Snowpack", "physical_parameters"]
