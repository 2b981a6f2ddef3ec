"""Sums over train scenes, each taken for a frame of one block."""

from job import job, progress

from snowsim.frames import frame_of_scene
from snowsim.io.files import write_dataset
from snowsim.io.scenes import SceneSet
from snowsim.statistics import merge, summarise, summary_to_dataset


def summarise_scenes(path_to_scenes, path_to_summary, **meaning):
    with SceneSet(path_to_scenes) as scenes:
        summary = merge(
            summarise(*frame_of_scene(scene, **meaning), where=scene.name)
            for scene in progress(scenes, "sums over scenes")
        )
    write_dataset(path_to_summary, summary_to_dataset(summary).assign_attrs(synthetic="no"))


if __name__ == "__main__":
    with job(snakemake):
        summarise_scenes(snakemake.input.scenes, snakemake.output.summary, **snakemake.params)
