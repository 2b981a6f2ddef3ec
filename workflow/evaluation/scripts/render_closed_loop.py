"""Render a shard of the label sets as linear power and reduce it to what the statistics need."""

from functools import partial

from main_path import job, progress

from evaluation.lib.closed_loop import summarise_renders
from snowsim.io.files import read_dataset, write_dataset
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream

with job(snakemake):
    stream = partial(random_stream, snakemake.params.seed, "closed_loop")
    flight = read_dataset(snakemake.input.statistics)
    with SceneSet(snakemake.input.layers) as drawn:
        scenes = enumerate(progress(drawn, "closed loop"), snakemake.params.first)
        sums = summarise_renders(scenes, flight, snakemake.params.phy, stream=stream)
    sums.attrs["synthetic"] = "renders by PHY, not observed data"
    write_dataset(snakemake.output.summary, sums)
