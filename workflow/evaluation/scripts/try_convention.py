"""One convention of PHY through the closed loop: statistics of renders of the first label sets."""

from functools import partial
from itertools import islice

from main_path import progress, run

from evaluation.lib.closed_loop import recover, summarise_renders
from evaluation.lib.conventions import Convention
from snowsim.io.files import read_dataset, write_dataset, write_table
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream


def try_convention(
    layers, statistics, recovered, table, *, convention, seed, phy, n_scenes, stride, varies
):
    stream = partial(random_stream, seed, "closed_loop")
    convention = Convention(**convention)
    given = read_dataset(statistics)
    with SceneSet(layers) as drawn:
        first = progress(islice(drawn, n_scenes), convention.name, total=n_scenes)
        renders = summarise_renders(enumerate(first), given, convention, phy, stride, stream)
    found, errors = recover(renders, given, varies=varies)
    write_dataset(recovered, found)
    write_table(table, errors)


run(try_convention)
