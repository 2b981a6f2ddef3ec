"""Label sets by the settings of the configuration."""

from lib.progress import progress
from snowsim.io.files import read_dataset
from snowsim.io.scenes import write_scenes
from snowsim.labels import Dress, Nonstationary, check_labels, draw_scene, prepare
from snowsim.seeding import random_stream


def label_model(
    flight,
    *,
    n_range_lines,
    n_layers,
    n_layers_range,
    first_slab,
    surface,
    correlation,
    radiometry,
    nonstationary,
    choices,
):
    """Label model of a flight's statistics by the settings of the configuration."""
    zones = nonstationary["zones"]
    folds = nonstationary | {"zones": zones and tuple(zones)}
    return prepare(
        flight,
        n_range_lines,
        n_layers=tuple(n_layers_range) if n_layers == "uniform" else n_layers,
        first_slab=first_slab,
        surface=surface,
        correlation=correlation,
        radiometry=radiometry,
        nonstationary=Nonstationary(**folds),
        dress=Dress(**choices),
    )


def draw_shard(statistics, labels, *, span, seed, n_range_lines, **settings):
    """Write the label sets of some numbers, from one and before another, drawn from statistics."""
    flight = read_dataset(statistics)
    model = label_model(flight, n_range_lines=n_range_lines, **settings)
    check_labels(model, rng=random_stream(seed, "check_labels"))
    names = [f"label_{number:06d}" for number in range(*span)]
    scenes = (
        # By scene, never by shard: how scenes are divided must not change them.
        draw_scene(model, n_range_lines, name=name, rng=random_stream(seed, "draw_labels", name))
        for name in progress(names, "labels")
    )
    write_scenes(labels, scenes, {"synthetic": flight.attrs["synthetic"]})
