"""Every output of every training set on a few test scenes, for the sheet of side outputs."""

import numpy as np
import xarray as xr
from main_path import progress, run

from lib.tracker_scores import read_tracker
from snowsim.io.files import write_dataset
from snowsim.io.scenes import SceneSet
from snowsim.tracker import OUTPUTS

N_ROWS = 300  # the least height of a scene: panels then have one scale


def choose_scenes(scenes, n_scenes):
    """Places of scenes at even ranks of the number of layers, neither the fewest nor the most."""
    n_layers = [scene.layer_bins.shape[0] for scene in scenes]
    ranked = sorted(range(len(scenes)), key=n_layers.__getitem__)
    ranks = np.linspace(0, len(ranked) - 1, n_scenes + 2)[1:-1]
    return list(dict.fromkeys(ranked[round(rank)] for rank in ranks))


def track_samples(scenes, networks, samples, *, training_sets, device, n_scenes):
    with SceneSet(scenes) as test_scenes:
        chosen = [test_scenes[place] for place in choose_scenes(test_scenes, n_scenes)]
    maps = []
    for path in progress(networks, "side outputs"):
        tracker = read_tracker(path, device)
        probabilities = np.stack([tracker.track(scene.image)[:, :N_ROWS] for scene in chosen])
        maps.append(np.rint(255 * probabilities).astype(np.uint8))
    images = np.stack([scene.image[:N_ROWS] for scene in chosen])
    masks = np.stack([scene.mask()[:N_ROWS] for scene in chosen]).astype(np.uint8)
    pixels = ("scene", "range_bin", "range_line")
    of_outputs = ("training_set", "scene", "output", "range_bin", "range_line")
    found = xr.Dataset(
        {
            "probability": (of_outputs, np.stack(maps), {"units": "1/255"}),
            "image": (pixels, images),
            "mask": (pixels, masks),
        },
        {
            "training_set": training_sets,
            "scene": [scene.name for scene in chosen],
            "output": list(OUTPUTS),
        },
    )
    write_dataset(samples, found)


run(track_samples)
