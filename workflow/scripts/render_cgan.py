"""Render one shard of scenes with the trained generator."""

import dataclasses

from job import job, progress

from lib.cgan_training import GENERATOR
from snowsim.cgan import Settings, render, trained_generator
from snowsim.io.files import read_dataset
from snowsim.io.models import read_model
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.labels import echoes_of_layers
from snowsim.seeding import random_stream

with job(snakemake):
    statistics = read_dataset(snakemake.input.statistics)
    weights, made_of = read_model(snakemake.input.generator, GENERATOR)
    settings = Settings(**made_of["settings"])
    generator = trained_generator(weights, settings, device=snakemake.params.device)

    def rendered(scene):
        """The scene with its image."""
        # By scene, never by shard: how scenes are divided must not change them.
        rng = random_stream(snakemake.params.seed, "render_cgan", scene.name)
        echoes = scene.echoes or echoes_of_layers(scene.layer_bins, statistics)
        image = render(generator, dataclasses.replace(scene, echoes=echoes), settings, rng=rng)
        return dataclasses.replace(scene, image=image, complete_layer_bins=None, echoes=None)

    attributes = {"method": "cGAN", "synthetic": snakemake.params.source}
    with SceneSet(snakemake.input.layers) as drawn:
        write_scenes(snakemake.output.scenes, map(rendered, progress(drawn, "cGAN")), attributes)
