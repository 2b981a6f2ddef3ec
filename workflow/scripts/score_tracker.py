"""Edge counts of trackers on a set of scenes, every output, every threshold.

Picks from their fused outputs.
"""

from job import job, progress

from lib.tracker_scores import count_edges, pick_scenes, read_tracker
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet

with job(snakemake), SceneSet(snakemake.input.scenes) as scenes:
    for i, network in enumerate(snakemake.input.networks):
        tracker = read_tracker(network, snakemake.params.device)
        counts, fused = count_edges(tracker, progress(scenes, "edge scores"))
        write_table(snakemake.output.picks[i], pick_scenes(scenes, fused, counts))
        write_table(snakemake.output.counts[i], counts)
