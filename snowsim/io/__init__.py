"""Files to datasets and back; the only package that opens files."""

import lazy_loader

from snowsim.echogram import echogram

# By the module they are in, loaded at first use: every job imports this package, and h5py, scipy
# and xarray take a second.
MODULES = {
    "echograms": ["read_echogram"],
    "files": ["read_dataset", "read_table", "write_dataset", "write_table", "written_whole"],
    "frames": ["check_frames", "read_frame", "read_frames"],
    "layers": [
        "open_segment",
        "open_segments",
        "read_layers",
        "write_layer_files",
        "write_layers",
    ],
    "models": ["fingerprint", "read_model", "read_tracker", "write_model"],
    "pairs": [
        "PairSet",
        "export_pairs",
        "layer_numbers",
        "layers_of_labels",
        "read_image",
        "read_mask",
        "read_pair",
        "write_image",
    ],
    "pictures": ["write_picture"],
    "place_pictures": ["write_places"],
    "profiles": ["Profile", "read_profile"],
    "scenes": ["SceneSet", "write_scenes"],
}
__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submod_attrs=MODULES)
__all__ = [*__all__, "echogram"]
