"""Render one shard of scenes with the trained generator."""

import dataclasses

from job import job, progress

from snowsim.cgan import Settings, render_as_expected, trained_generator
from snowsim.cgan.scope import outside
from snowsim.io.files import read_dataset
from snowsim.io.models import read_model
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.seeding import random_stream

with job(snakemake) as log:
    flight = read_dataset(snakemake.input.statistics)
    weights, made_of = read_model(snakemake.input.generator, {"kind": "cgan generator"})
    settings = Settings(**made_of["settings"])
    generator = trained_generator(weights, settings, device=snakemake.params.device)
    known = {"flight": flight, "fade_spread": made_of["fade_spread"]}
    beyond = []

    def rendered(scene):
        """The scene with its image, and in what it lies outside the scenes trained on."""
        # By scene, never by shard: how scenes are divided must not change them.
        rng = random_stream(snakemake.params.seed, "render_cgan", scene.name)
        image = render_as_expected(generator, scene, settings, **known, rng=rng)
        found = outside(scene, made_of["scope"])
        beyond.append(bool(found))
        notes = scene.notes | {"outside_training": "; ".join(found)}
        return dataclasses.replace(
            scene, image=image, complete_layer_bins=None, echoes=None, notes=notes
        )

    attributes = {"method": "cGAN", "synthetic": snakemake.params.source}
    with SceneSet(snakemake.input.layers) as drawn:
        write_scenes(snakemake.output.scenes, map(rendered, progress(drawn, "cGAN")), attributes)
        said = "%d of %d scenes lie outside what the generator was trained on"
        log.info(said, sum(beyond), len(drawn))
