"""Render one shard of scenes by a function of someone's own."""

import dataclasses

from job import job, progress

from lib.own_functions import own_function
from snowsim.front import rendered_by
from snowsim.io.files import read_dataset
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.labels import echoes_of_layers

with job(snakemake):
    flight = read_dataset(snakemake.input.statistics)
    renderer = own_function(snakemake.input.function, snakemake.params.renderer)

    def rendered(scene):
        """The scene with its image; one without echoes of its own has the flight's mean powers."""
        echoes = scene.echoes or echoes_of_layers(scene.layer_bins, flight)
        return rendered_by(dataclasses.replace(scene, echoes=echoes), renderer)

    attributes = {"method": snakemake.params.renderer, "synthetic": flight.attrs["synthetic"]}
    with SceneSet(snakemake.input.layers) as drawn:
        scenes = map(rendered, progress(drawn, snakemake.params.renderer))
        write_scenes(snakemake.output.scenes, scenes, attributes)
