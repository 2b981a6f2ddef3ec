"""Sums over train scenes, each taken for a frame of one block."""

from job import progress, run

from snowsim.frames import frame_of_scene
from snowsim.io.files import write_dataset
from snowsim.io.scenes import SceneSet
from snowsim.statistics import merge, summarise, summary_to_dataset


def summarise_scenes(scenes, summary, **meaning):
    with SceneSet(scenes) as train:
        shown = progress(train, "sums over scenes")
        merged = merge(
            summarise(*frame_of_scene(scene, **meaning), where=scene.name) for scene in shown
        )
    write_dataset(summary, summary_to_dataset(merged).assign_attrs(synthetic="no"))


run(summarise_scenes)
