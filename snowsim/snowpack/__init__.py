"""Snow as its users know it: density and depth, what a radar sees of them, accumulation."""

import lazy_loader

# Functions and classes by their module, loaded at first use: who checks settings needs firn alone.
FACE = {
    "physical": ["Climate", "PRESETS", "Radar", "Snowpack", "physical_parameters"],
    "profile": ["Reflectors", "combine"],
    "simulation": ["simulate"],
    "snow": ["accumulation"],
    "tables": ["by_year", "pieces", "table"],
}
__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submod_attrs=FACE)
