"""Snow in physical units: density and depth, their radar echoes, and accumulation."""

import lazy_loader

# Functions and classes by their module. They are loaded at first use, so that the schema, which
# needs firn alone, loads no other module.
FACE = {
    "matching": ["agreement", "agreement_summary", "agreement_table"],
    "physical": ["Climate", "PRESETS", "Radar", "Snowpack", "physical_parameters"],
    "profile": ["Reflectors", "combine"],
    "simulation": ["simulate"],
    "snow": ["accumulation"],
    "tables": ["by_year", "pieces", "table"],
}
__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submod_attrs=FACE)
