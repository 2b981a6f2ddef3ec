"""Edge counts of trackers on test scenes, every output, every threshold, and on validation scenes.

Picks from their fused outputs. Where there are validation scenes, every output of a tracker is
calibrated on these first.
"""

from job import job, progress

from lib.tracker_scores import best_thresholds, count_edges, pick_scenes, read_tracker
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet

with job(snakemake), SceneSet(snakemake.input.scenes) as scenes:
    for i, network in enumerate(snakemake.input.networks):
        tracker = read_tracker(network, snakemake.params.device)
        at = None
        if snakemake.input.validation:
            with SceneSet(snakemake.input.validation) as held:
                tracker = tracker.calibrated(progress(held, "calibration"))
                counts, _ = count_edges(tracker, progress(held, "validation scenes"))
            write_table(snakemake.output.validation[i], counts)
            at = best_thresholds(counts)
        counts, fused = count_edges(
            tracker,
            progress(scenes, "edge scores"),
            at=at,
            as_published=snakemake.params.as_published,
        )
        write_table(snakemake.output.picks[i], pick_scenes(scenes, fused, counts))
        write_table(snakemake.output.counts[i], counts)
