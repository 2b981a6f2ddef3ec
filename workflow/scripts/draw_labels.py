"""Draw one shard of synthetic layer sets from the flight statistics."""

from job import progress, run

from snowsim.io.files import read_dataset
from snowsim.io.scenes import write_scenes
from snowsim.labels import Nonstationary, draw_scene, prepare
from snowsim.seeding import random_stream


def draw_shard(
    statistics, labels, *, span, n_range_lines, n_layers, n_layers_range, drawn, nonstationary, seed
):
    flight = read_dataset(statistics)
    nonstationary = Nonstationary(
        **nonstationary | {"zones": nonstationary["zones"] and tuple(nonstationary["zones"])}
    )
    n_layers = tuple(n_layers_range) if n_layers == "uniform" else n_layers
    model = prepare(flight, n_range_lines, n_layers=n_layers, **drawn, nonstationary=nonstationary)
    names = [f"label_{scene:06d}" for scene in range(*span)]
    scenes = (
        # By scene, never by shard: how scenes are divided must not change them.
        draw_scene(model, n_range_lines, name=name, rng=random_stream(seed, "draw_labels", name))
        for name in progress(names, "labels")
    )
    write_scenes(labels, scenes, {"synthetic": flight.attrs["synthetic"]})


run(draw_shard)
