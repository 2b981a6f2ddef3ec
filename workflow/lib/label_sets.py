"""Label sets by the settings of the configuration."""

from lib.phy_renders import dress_of
from lib.progress import progress
from snowsim.labels import Nonstationary, check_labels, draw_scene, prepare
from snowsim.seeding import random_stream


def draw_sets(flight, settings, choices, *, span, seed):
    """The label sets of some numbers, from one and before another, drawn from statistics.

    `settings` are those of the configuration's labels, `choices` those of PHY that a set records.
    """
    n_range_lines = settings["n_range_lines"]
    n_layers = settings["n_layers"]
    if n_layers == "uniform":
        n_layers = (settings["n_layers_min"], settings["n_layers_max"])
    zones = settings["nonstationary"]["zones"]
    folds = settings["nonstationary"] | {"zones": zones and tuple(zones)}
    model = prepare(
        flight,
        n_range_lines,
        n_layers=n_layers,
        first_slab=settings["first_slab"],
        surface=settings["surface"],
        correlation=settings["correlation"],
        radiometry=settings["radiometry"],
        nonstationary=Nonstationary(**folds),
        dress=dress_of(choices),
    )
    check_labels(model, rng=random_stream(seed, "check_labels"))
    for number in progress(range(*span), "labels"):
        name = f"label_{number:06d}"
        # By scene, never by shard: how scenes are divided must not change them.
        rng = random_stream(seed, "draw_labels", name)
        yield draw_scene(model, n_range_lines, name=name, rng=rng)
