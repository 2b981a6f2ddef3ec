"""Render one shard of scenes with the trained generator."""

import dataclasses

from job import logger, progress, run

from lib.guides import expected_brightness
from lib.scope import outside
from snowsim.cgan import Settings, render, trained_generator
from snowsim.io.files import read_dataset
from snowsim.io.models import read_model
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.seeding import random_stream


def scene_renderer(path_to_generator, flight, device):
    """Function that renders a scene by a trained generator, given a random generator; and what it was trained on."""
    weights, metadata = read_model(path_to_generator, {"kind": "cgan generator"})
    settings = Settings(**metadata["settings"])
    network = trained_generator(weights, settings, device=device)

    def by_network(scene, rng):
        brightness = expected_brightness(scene, flight) if settings.method == "depth" else None
        return render(network, scene, settings, brightness=brightness, rng=rng)

    return by_network, metadata["scope"]


def render_shard(layers, generator, statistics, scenes, *, seed, device, source):
    render_scene, scope = scene_renderer(generator, read_dataset(statistics), device)
    beyond = []

    def rendered(scene):
        image = render_scene(
            scene, random_stream(seed, "render_cgan", scene.name)
        )  # by scene, never by shard
        beyond.append("; ".join(outside(scene, scope)))
        notes = scene.notes | {"outside_training": beyond[-1]}
        return dataclasses.replace(
            scene, image=image, complete_layer_bins=None, peak_power=None, notes=notes
        )

    with SceneSet(layers) as drawn:
        write_scenes(
            scenes, map(rendered, progress(drawn, "cGAN")), {"method": "cGAN", "synthetic": source}
        )
    logger.info(
        "%d of %d scenes lie outside what the generator was trained on",
        sum(map(bool, beyond)),
        len(beyond),
    )


run(render_shard)
