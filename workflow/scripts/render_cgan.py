"""Render one shard of scenes with the trained generator."""

import dataclasses

from job import logger, progress, run

from lib.brightness import expected_levels
from lib.scope import outside
from snowsim.cgan import Settings, render, trained_generator
from snowsim.io.files import read_dataset
from snowsim.io.models import read_model
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.seeding import random_stream


def scene_renderer(path_to_generator, flight, device):
    """A trained generator as a function of scene and random stream; and what it was trained on."""
    weights, metadata = read_model(path_to_generator, {"kind": "cgan generator"})
    settings = Settings(**metadata["settings"])
    network = trained_generator(weights, settings, device=device)
    spread = metadata["fade_spread"]

    def by_network(scene, rng):
        levels = None
        if settings.method == "depth":
            levels = expected_levels(scene, flight, fade_spread=spread, rng=rng)
        return render(network, scene, settings, levels=levels, rng=rng)

    return by_network, metadata["scope"]


def render_shard(layers, generator, statistics, scenes, *, seed, device, source):
    render_scene, scope = scene_renderer(generator, read_dataset(statistics), device)
    n_outside = 0

    def rendered(drawn):
        nonlocal n_outside
        for scene in progress(drawn, "cGAN"):
            # By scene, never by shard: how scenes are divided must not change them.
            image = render_scene(scene, random_stream(seed, "render_cgan", scene.name))
            beyond = outside(scene, scope)
            n_outside += bool(beyond)
            notes = scene.notes | {"outside_training": "; ".join(beyond)}
            yield dataclasses.replace(
                scene, image=image, complete_layer_bins=None, echoes=None, notes=notes
            )

    with SceneSet(layers) as drawn:
        write_scenes(scenes, rendered(drawn), {"method": "cGAN", "synthetic": source})
        logger.info(
            "%d of %d scenes lie outside what the generator was trained on", n_outside, len(drawn)
        )


run(render_shard)
