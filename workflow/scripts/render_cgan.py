"""Render one shard of scenes with the trained generator."""

import dataclasses

from job import progress, run

from snowsim.cgan import Settings, render, trained_generator
from snowsim.io.models import read_model
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.seeding import random_stream


def scene_renderer(path_to_generator, device, statistics):
    """Function that renders a scene by a trained generator, with a random generator for the dropout."""
    weights, metadata = read_model(path_to_generator, {"kind": "cgan generator"})
    settings = Settings(**metadata["settings"])
    network = trained_generator(weights, settings, device=device)
    options = {"dropout": settings.dropout, "precision": settings.precision, "statistics": statistics}
    return lambda scene, rng: render(network, scene.mask(), **options, rng=rng)


def render_shard(layers, generator, scenes, *, seed, device, statistics, source):
    render_scene = scene_renderer(generator, device, statistics)

    def rendered(scene):
        image = render_scene(scene, random_stream(seed, "render_cgan", scene.name))  # by scene, never by shard
        return dataclasses.replace(scene, image=image, complete_layer_bins=None, peak_power=None)

    with SceneSet(layers) as drawn:
        write_scenes(scenes, map(rendered, progress(drawn, "cGAN")), {"method": "cGAN", "synthetic": source})


run(render_shard)
