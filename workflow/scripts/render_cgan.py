"""Render one shard of scenes with the trained generator."""

import dataclasses

import torch
from job import job, progress

from snowsim.cgan import Settings, render, trained_generator
from snowsim.io.models import read_model
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.seeding import random_stream


def read_generator(path, device):
    """The trained generator and the settings it was trained with."""
    weights, metadata = read_model(path, {"kind": "cgan generator"})
    settings = Settings(**metadata["settings"])
    return trained_generator(weights, settings, device=device), settings


def render_shard(path_to_layers, path_to_generator, path_to_scenes, seed, device, statistics, source):
    torch.set_num_threads(1)
    generator, settings = read_generator(path_to_generator, device)

    def render_scene(scene):
        rng = random_stream(seed, "render_cgan", scene.name)  # by scene, never by shard
        image = render(
            generator,
            scene.mask(),
            dropout=settings.dropout,
            statistics=statistics,
            precision=settings.precision,
            rng=rng,
        )
        return dataclasses.replace(scene, image=image, complete_layer_bins=None)

    with SceneSet(path_to_layers) as layers:
        scenes = (render_scene(scene) for scene in progress(layers, "cGAN"))
        write_scenes(path_to_scenes, scenes, {"method": "cGAN", "synthetic": source})


if __name__ == "__main__":
    with job(snakemake):
        render_shard(snakemake.input.layers, snakemake.input.generator, snakemake.output.scenes, **snakemake.params)
