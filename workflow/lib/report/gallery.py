"""The report's gallery: which test scenes it shows, their images compressed, their layers as lines a page can draw."""

import numpy as np

from lib.figures.style import METHODS, evenly_spaced
from lib.report.page import image_uri

LINE_STEP = 2  # every other range line of a layer is drawn
METRICS = ("ssim", "psnr", "rmse")


def gallery_of(scenes, images, n_scenes):
    """Test scenes spread over their number of layers, as plain values; `images` is the table of similarity."""
    scores = images.set_index(["scene", "method"])[list(METRICS)].to_dict("index")
    rounded = {
        key: {metric: round(float(score), 3) for metric, score in of.items()}
        for key, of in scores.items()
    }
    chosen = evenly_spaced([scene.layer_bins.shape[0] for scene in scenes["observed"]], n_scenes)
    return [
        {
            "name": scene.name,
            "n_range_bins": scene.n_range_bins,
            "n_range_lines": scene.n_range_lines,
            "n_layers": scene.layer_bins.shape[0] - 1,
            "layers": layer_lines(scene.layer_bins),
            "images": {name: image_uri(of[i].image) for name, of in scenes.items()},
            "scores": {method: rounded[scene.name, method] for method in METHODS},
        }
        for i, scene in ((int(i), scenes["observed"][int(i)]) for i in chosen)
    ]


def layer_lines(layer_bins, step=LINE_STEP):
    """Layers (layer, range_line) as unbroken pieces [range_line, range_bin, range_line, ...], each `step`-th line."""
    layer_bins = np.asarray(layer_bins, dtype=float)
    chosen = np.unique(np.r_[np.arange(0, layer_bins.shape[1], step), layer_bins.shape[1] - 1])
    layers = []
    for bins in layer_bins[:, chosen]:
        present = np.isfinite(bins)
        starts = np.flatnonzero(present & ~np.r_[False, present[:-1]])
        stops = np.flatnonzero(present & ~np.r_[present[1:], False]) + 1
        points = np.column_stack([chosen, np.round(bins, 1)])
        layers.append([points[a:b].ravel().tolist() for a, b in zip(starts, stops, strict=True)])
    return layers
