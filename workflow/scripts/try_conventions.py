"""Conventions of PHY through the closed loop: statistics of renders of the first label sets."""

from functools import partial
from itertools import islice

from job import progress, run

from lib.conventions import Convention
from lib.diagnostics.closed_loop import recover, summarise_renders
from snowsim.io.files import read_dataset, write_dataset, write_table
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream


def try_conventions(
    layers, statistics, recovered, tables, *, conventions, seed, phy, n_scenes, stride, varies
):
    stream = partial(random_stream, seed, "closed_loop")
    files = zip(conventions, statistics, recovered, tables, strict=True)
    for choices, path_to_given, path_to_recovered, path_to_table in files:
        convention = Convention(**choices)
        given = read_dataset(path_to_given)
        with SceneSet(layers) as drawn:
            first = progress(islice(drawn, n_scenes), convention.name, total=n_scenes)
            renders = summarise_renders(enumerate(first), given, convention, phy, stride, stream)
        found, table = recover(renders, given, varies=varies)
        write_dataset(path_to_recovered, found)
        write_table(path_to_table, table)


run(try_conventions)
