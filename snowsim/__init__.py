"""Simulation of airborne Snow Radar echograms, to train and score trackers of annual layers."""

import lazy_loader

__version__ = "0.6.0"

# Names for scripts, by the module that defines them. A module is loaded when one of its names is
# first used, so that `import snowsim` imports no stage.
FRONT = {
    "front": ["scenes"],
    "scoring": ["score_folders"],
    "snowpack": ["Climate", "Radar", "Snowpack", "accumulation", "agreement", "simulate"],
    "tracking": ["Tracker", "list_pretrained"],
}
__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submod_attrs=FRONT)
