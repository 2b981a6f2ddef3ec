"""Tracks layers in echograms with a trained tracker: datasets in memory, or files to files.

`snowsim.io` opens the files and `snowsim.tracker` picks the layers; this package joins the two.
"""

import lazy_loader

# Names of the package by module.
MODULES = {
    "files": ["track_files"],
    "trackers": ["Tracker", "list_pretrained"],
}
__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submod_attrs=MODULES)
