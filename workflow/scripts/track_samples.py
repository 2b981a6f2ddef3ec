"""Every output of every training set on a few test scenes, for the sheet of side outputs."""

import numpy as np
import xarray as xr
from job import progress, run

from snowsim.io.files import write_dataset
from snowsim.io.models import read_model
from snowsim.io.scenes import SceneSet
from snowsim.tracker import OUTPUTS, Settings, track, trained_network

N_ROWS = 300  # the least height of a scene: panels then have one scale


def choose_scenes(scenes, n_scenes):
    """Places of scenes at evenly spaced ranks of the number of layers, neither the fewest nor the most; each once."""
    ranked = sorted(
        range(len(scenes)), key=lambda place: (scenes[place].layer_bins.shape[0], place)
    )
    ranks = np.linspace(0, len(ranked) - 1, n_scenes + 2)[1:-1]
    return list(dict.fromkeys(ranked[round(rank)] for rank in ranks))


def track_samples(scenes, networks, samples, *, training_sets, device, n_scenes):
    with SceneSet(scenes) as test_scenes:
        chosen = [test_scenes[place] for place in choose_scenes(test_scenes, n_scenes)]
    maps = []
    for path in progress(networks, "side outputs"):
        weights, metadata = read_model(path, {"kind": "tracker"})
        settings = Settings(**metadata["settings"])
        network = trained_network(weights, settings, device=device)
        probabilities = [
            track(network, scene.image, precision=settings.precision)[:, :N_ROWS]
            for scene in chosen
        ]
        maps.append(np.rint(255 * np.stack(probabilities)).astype(np.uint8))
    dims = ("training_set", "scene", "output", "range_bin", "range_line")
    images = np.stack([scene.image[:N_ROWS] for scene in chosen])
    masks = np.stack([scene.mask()[:N_ROWS] for scene in chosen]).astype(np.uint8)
    found = {"probability": (dims, np.stack(maps), {"units": "1/255"})}
    found |= {
        name: (("scene", *dims[3:]), values)
        for name, values in (("image", images), ("mask", masks))
    }
    names = {
        "training_set": training_sets,
        "scene": [scene.name for scene in chosen],
        "output": list(OUTPUTS),
    }
    write_dataset(samples, xr.Dataset(found, names))


run(track_samples)
