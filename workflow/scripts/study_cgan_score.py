"""Similarity of other generators' renders of the test masks to the observed scenes, and its spread over seeds."""

import pandas as pd
import torch
from job import progress, run
from render_cgan import scene_renderer

from lib.diagnostics.cgan_studies import seeds_table
from snowsim.io.files import read_table, write_table
from snowsim.io.scenes import SceneSet
from snowsim.metrics.image import similarity
from snowsim.seeding import random_stream


def score(observed, default, generators, images, table, *, seed, seeds, device, statistics):
    torch.set_num_threads(1)
    for generator, path in zip(generators, images, strict=True):
        render_scene = scene_renderer(generator, device, statistics)
        rows = []
        with SceneSet(observed) as scenes:
            for scene in progress(scenes, "cGAN"):
                # The dropout of the default run: what differs is the training alone.
                image = render_scene(scene, random_stream(seed, "render_cgan", scene.name))
                rows.append({"scene": scene.name, "method": "cgan", **similarity(image, scene.image)})
        write_table(path, pd.DataFrame(rows))
    write_table(table, seeds_table(read_table(default), map(read_table, images), seeds))


run(score)
