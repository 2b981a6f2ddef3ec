"""Label sets by the settings of the configuration."""

from functools import partial

from lib.progress import progress
from snowsim.labels import Nonstationary, draw_paper_scene, draw_scene, prepare
from snowsim.seeding import random_stream


def draw_sets(flight, settings, *, span, seed):
    """The label sets of some numbers, from one and before another, drawn from statistics.

    `settings` are those of the configuration's labels.
    """
    n_range_lines = settings["n_range_lines"]
    draw = partial(draw_paper_scene, flight, n_range_lines)
    if settings["recipe"] == "measured":
        folds = Nonstationary(**settings["nonstationary"])
        model = prepare(flight, n_range_lines, nonstationary=folds)
        draw = partial(draw_scene, model, n_range_lines)
    for number in progress(range(*span), "labels"):
        name = f"label_{number:06d}"
        # By scene, never by shard: how scenes are divided must not change them.
        yield draw(name=name, rng=random_stream(seed, "draw_labels", name))
