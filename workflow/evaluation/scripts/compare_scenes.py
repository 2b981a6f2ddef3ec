"""Observed train scenes beside rendered label sets, the sets of the input: the two-sample test."""

from functools import partial
from itertools import islice

from main_path import job

from evaluation.lib.two_sample import two_sample_table
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream

with job(snakemake):
    params = snakemake.params
    sets = {}
    for name, paths in snakemake.input.items():
        with SceneSet(paths) as scenes:
            sets[name] = list(islice(scenes, params.n_scenes))
    n = min(map(len, sets.values()))
    for scenes in sets.values():
        del scenes[n:]
    table = two_sample_table(
        sets,
        n_splits=params.n_splits,
        n_steps=params.n_steps,
        stream=partial(random_stream, params.seed, "compare_scenes"),
    )
    write_table(snakemake.output.two_sample, table)
