"""Similarity of one generator's renders of the test masks to the observed scenes, image by image."""

import pandas as pd
import torch
from job import job, progress
from render_cgan import scene_renderer

from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet
from snowsim.metrics.image import similarity
from snowsim.seeding import random_stream


def score(paths_to_observed, path_to_generator, path_to_images, seed, device, statistics):
    torch.set_num_threads(1)
    render_scene = scene_renderer(path_to_generator, device, statistics)
    rows = []
    with SceneSet(paths_to_observed) as scenes:
        for scene in progress(scenes, "cGAN"):
            # The dropout of the default run: what differs is the training alone.
            image = render_scene(scene, random_stream(seed, "render_cgan", scene.name))
            rows.append({"scene": scene.name, "method": "cgan", **similarity(image, scene.image)})
    write_table(path_to_images, pd.DataFrame(rows))


if __name__ == "__main__":
    with job(snakemake):
        score(snakemake.input.observed, snakemake.input.generator, snakemake.output.images, **snakemake.params)
