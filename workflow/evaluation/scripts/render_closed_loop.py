"""Render a shard of the label sets as linear power and reduce it to what the statistics need."""

from functools import partial

from main_path import progress, run

from evaluation.lib.closed_loop import summarise_renders
from evaluation.lib.conventions import Convention
from snowsim.io.files import read_dataset, write_dataset
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream
from snowsim.statistics import summary_to_dataset


def render_closed_loop(layers, statistics, summary, *, convention, seed, phy, first, stride):
    stream = partial(random_stream, seed, "closed_loop")
    given = read_dataset(statistics)
    with SceneSet(layers) as drawn:
        scenes = enumerate(progress(drawn, "closed loop"), first)
        renders = summarise_renders(scenes, given, Convention(**convention), phy, stride, stream)
    sums = summary_to_dataset(renders)
    write_dataset(summary, sums.assign_attrs(synthetic="renders by PHY, not observed data"))


run(render_closed_loop)
