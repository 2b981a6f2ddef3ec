"""Conventions of PHY through the closed loop: renders of the first label sets, and their statistics."""

from functools import partial
from itertools import islice

from job import progress, run

from lib.diagnostics.closed_loop import recover, summarise_renders
from snowsim.io.files import read_dataset, write_dataset, write_table
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream


def try_conventions(
    layers, statistics, recovered, tables, *, conventions, seed, phy, n_scenes, stride, varies
):
    stream = partial(random_stream, seed, "closed_loop")
    for convention, path_to_given, *paths in zip(
        conventions, statistics, recovered, tables, strict=True
    ):
        given = read_dataset(path_to_given)
        with SceneSet(layers) as drawn:
            scenes = enumerate(progress(islice(drawn, n_scenes), convention, total=n_scenes))
            renders = summarise_renders(scenes, given, convention, phy, stride, stream)
        found, table = recover(renders, given, varies=varies)
        write_dataset(paths[0], found)
        write_table(paths[1], table)


run(try_conventions)
