"""Edge counts of trackers on a set of scenes, every output, every threshold.

Picks from their fused outputs.
"""

from job import progress, run

from lib.tracker_scores import count_edges, pick_scenes, read_tracker
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet
from snowsim.tracker import OUTPUTS


def score_trackers(scenes, networks, counts, picks=(), *, device, outputs=OUTPUTS):
    # No picks are written where there is no path to them.
    paths_to_picks = picks or [None] * len(counts)
    with SceneSet(scenes) as test_scenes:
        for network, path, path_to_picks in zip(networks, counts, paths_to_picks, strict=True):
            tracker = read_tracker(network, device)
            table, edges = count_edges(tracker, progress(test_scenes, "edge scores"), outputs)
            if path_to_picks is not None:
                write_table(path_to_picks, pick_scenes(test_scenes, edges, table))
            write_table(path, table)


run(score_trackers)
