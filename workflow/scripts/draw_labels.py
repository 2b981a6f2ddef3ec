"""Draw one shard of synthetic layer sets from the flight statistics."""

from job import job, progress

from snowsim.io.files import read_dataset
from snowsim.io.scenes import write_scenes
from snowsim.labels import Beyond, draw_scene, prepare
from snowsim.seeding import random_stream


def draw_shard(path_to_statistics, path_to_labels, span, n_range_lines, n_layers, correlation, beyond, seed):
    statistics = read_dataset(path_to_statistics)
    beyond = Beyond(**beyond | {"zones": beyond["zones"] and tuple(beyond["zones"])})
    model = prepare(statistics, n_range_lines, n_layers=tuple(n_layers), correlation=correlation, beyond=beyond)
    names = [f"label_{scene:06d}" for scene in range(*span)]
    scenes = (
        # By scene, never by shard: how scenes are divided must not change them.
        draw_scene(model, n_range_lines, name=name, rng=random_stream(seed, "draw_labels", name))
        for name in progress(names, "labels")
    )
    write_scenes(path_to_labels, scenes, {"synthetic": statistics.attrs["synthetic"]})


if __name__ == "__main__":
    with job(snakemake):
        draw_shard(snakemake.input.statistics, snakemake.output.labels, **snakemake.params)
