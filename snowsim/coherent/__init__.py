"""A layered medium seen straight down, coherent and with all multiples: the arbiter of simpler models."""

from snowsim.coherent.layers import fresnel, interface_delays_s, reflect, reflect_once
from snowsim.coherent.sweep import incoherent_profile, mean_profile, sweep_frequencies_hz

__all__ = [
    "fresnel",
    "incoherent_profile",
    "interface_delays_s",
    "mean_profile",
    "reflect",
    "reflect_once",
    "sweep_frequencies_hz",
]
