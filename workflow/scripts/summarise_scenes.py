"""Summary of train scenes, each of which counts as a frame of one block."""

from job import job, progress

from lib.placeholder_frames import frame_of_scene
from snowsim.io.files import write_dataset
from snowsim.io.scenes import SceneSet
from snowsim.statistics import merge, summarise

with job(snakemake), SceneSet(snakemake.input.scenes) as train:
    summaries = []
    for scene in progress(train, "sums over scenes"):
        frame = frame_of_scene(scene, **snakemake.params)
        summaries.append(summarise(*frame, where=scene.name))
    merged = merge(summaries)
    write_dataset(snakemake.output.summary, merged.assign_attrs(synthetic="no"))
