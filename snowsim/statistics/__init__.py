"""Flight statistics from annotated frames: summarise each, merge in any order, estimate once."""

from snowsim.statistics.flight import ESTIMATORS, estimate, fit, warn_of_little
from snowsim.statistics.speckle import doppler_spectra
from snowsim.statistics.summaries import merge, summarise
from snowsim.statistics.variation import Ranges, Variation, changed, varied

__all__ = [
    "ESTIMATORS",
    "Ranges",
    "Variation",
    "changed",
    "doppler_spectra",
    "estimate",
    "fit",
    "merge",
    "summarise",
    "varied",
    "warn_of_little",
]
