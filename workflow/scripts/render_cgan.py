"""Render one shard of scenes with the trained generator."""

import dataclasses

import torch
from job import job, progress

from snowsim.cgan import Settings, render, trained_generator
from snowsim.io.models import read_model
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.seeding import random_stream


def scene_renderer(path_to_generator, device, statistics):
    """Function that renders a scene by a trained generator, with a random generator for the dropout."""
    weights, metadata = read_model(path_to_generator, {"kind": "cgan generator"})
    settings = Settings(**metadata["settings"])
    generator = trained_generator(weights, settings, device=device)

    def render_scene(scene, rng):
        options = {"dropout": settings.dropout, "precision": settings.precision, "statistics": statistics}
        return render(generator, scene.mask(), **options, rng=rng)

    return render_scene


def render_shard(path_to_layers, path_to_generator, path_to_scenes, seed, device, statistics, source):
    torch.set_num_threads(1)
    render_scene = scene_renderer(path_to_generator, device, statistics)

    def rendered(scene):
        image = render_scene(scene, random_stream(seed, "render_cgan", scene.name))  # by scene, never by shard
        return dataclasses.replace(scene, image=image, complete_layer_bins=None)

    with SceneSet(path_to_layers) as layers:
        scenes = (rendered(scene) for scene in progress(layers, "cGAN"))
        write_scenes(path_to_scenes, scenes, {"method": "cGAN", "synthetic": source})


if __name__ == "__main__":
    with job(snakemake):
        render_shard(snakemake.input.layers, snakemake.input.generator, snakemake.output.scenes, **snakemake.params)
