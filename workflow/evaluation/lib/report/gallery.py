"""The report's gallery: which test scenes it shows, their images, and their layers as lines."""

import numpy as np

from evaluation.lib.figures.style import METHODS, evenly_spaced
from evaluation.lib.report.page import image_uri
from snowsim.metrics.pick_tables import snow_per_bin_m

LINE_STEP = 2  # every other range line of a layer is drawn
METRICS = ("ssim", "psnr", "rmse")


def depth_scale(bin_size_s, snow_density_kg_m3):
    """Delay of a range bin [s], and its thickness in snow of some density and in air [m]."""
    return {
        "bin_size_s": bin_size_s,
        "snow_per_bin_m": snow_per_bin_m(bin_size_s, snow_density_kg_m3),
        "air_per_bin_m": snow_per_bin_m(bin_size_s, 0),
    }


def gallery_of(scenes, images, n_scenes):
    """Test scenes spread over their number of layers, as plain values.

    `images` is the table of similarity.
    """
    scores = images.set_index(["scene", "method"])[list(METRICS)].astype(float).round(3)
    n_layers = [scene.layer_bins.shape[0] for scene in scenes["observed"]]
    gallery = []
    for number in evenly_spaced(n_layers, n_scenes).tolist():
        scene = scenes["observed"][number]
        shown = {
            "name": scene.name,
            "n_range_bins": scene.n_range_bins,
            "n_range_lines": scene.n_range_lines,
            "n_layers": scene.layer_bins.shape[0] - 1,
            "layers": layer_lines(scene.layer_bins),
            "images": {name: image_uri(of[number].image) for name, of in scenes.items()},
            "scores": {method: scores.loc[(scene.name, method)].to_dict() for method in METHODS},
        }
        gallery.append(shown)
    return gallery


def layer_lines(layer_bins, step=LINE_STEP):
    """Layers (layer, range_line) as unbroken pieces [range_line, range_bin, range_line, ...].

    Each `step`-th range line is kept, and the last.
    """
    layer_bins = np.asarray(layer_bins, dtype=float)
    last = layer_bins.shape[1] - 1
    lines = np.union1d(np.arange(0, last, step), last)
    layers = []
    for bins in layer_bins[:, lines]:
        points = np.column_stack([lines, np.round(bins, 1)])
        runs = np.ma.clump_unmasked(np.ma.masked_invalid(bins))
        layers.append([points[run].ravel().tolist() for run in runs])
    return layers
