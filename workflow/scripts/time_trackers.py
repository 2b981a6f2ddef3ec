"""Seconds per image of trackers of several widths, measured in turn, beside their fused scores."""

import pandas as pd
import torch
from job import job

from lib.timing import device_name, time_rounds
from snowsim.io.files import read_table, write_table
from snowsim.io.models import read_model
from snowsim.io.scenes import SceneSet
from snowsim.metrics.edges import score
from snowsim.metrics.tables import counts_by_image
from snowsim.tracker import Settings, track, trained_network


def tracking(network, settings, images):
    """Work that tracks the images once."""

    def work():
        for image in images:
            track(network, image, precision=settings.precision)

    return work


def measure(paths_to_scenes, paths_to_networks, paths_to_counts, path_to_table, names, n_scenes, n_rounds):
    torch.set_num_threads(1)
    with SceneSet(paths_to_scenes) as scenes:
        images = [scenes[place].image for place in range(min(n_scenes, len(scenes)))]
    works, facts = {}, {}
    for name, path, path_to_counts in zip(names, paths_to_networks, paths_to_counts, strict=True):
        weights, metadata = read_model(path, {"kind": "tracker"})
        settings = Settings(**metadata["settings"])
        scores = score(counts_by_image(read_table(path_to_counts)))
        works[name] = tracking(trained_network(weights, settings), settings, images)
        facts[name] = {
            "network": settings.network,
            "width": settings.width,
            "n_parameters": sum(array.size for array in weights.values()),
            **{metric: scores[metric] for metric in ("ods", "ois", "ap")},
        }
    n_pixels = sum(image.size for image in images) / len(images)
    rows = [
        {
            "setting": name,
            **facts[name],
            "repeat": repeat,
            "seconds": seconds / len(images),
            "ns_per_pixel": 1e9 * seconds / len(images) / n_pixels,
            "device": device_name(),
        }
        for name, repeat, seconds in time_rounds(works, n_rounds)
    ]
    write_table(path_to_table, pd.DataFrame(rows))


if __name__ == "__main__":
    with job(snakemake):
        measure(
            snakemake.input.scenes,
            snakemake.input.networks,
            snakemake.input.counts,
            *snakemake.output,
            **snakemake.params,
        )
