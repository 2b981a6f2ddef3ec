"""Seconds per image of trackers of several widths, measured in turn, beside their fused scores."""

from job import run

from lib.diagnostics.tracker_studies import time_tracking
from lib.score_tables import counts_by_image
from snowsim.io.files import read_table, write_table
from snowsim.io.models import read_model
from snowsim.io.scenes import SceneSet
from snowsim.metrics.edges import score
from snowsim.tracker import Settings, trained_network


def time_trackers(scenes, networks, counts, table, *, names, n_scenes, n_rounds):
    with SceneSet(scenes) as held:
        images = [held[place].image for place in range(min(n_scenes, len(held)))]
    trackers = {}
    for name, path, path_to_counts in zip(names, networks, counts, strict=True):
        weights, metadata = read_model(path, {"kind": "tracker"})
        settings = Settings(**metadata["settings"])
        scores = score(counts_by_image(read_table(path_to_counts)))
        n_parameters = sum(array.size for array in weights.values())
        known = {"network": settings.network, "width": settings.width, "n_parameters": n_parameters}
        known |= {metric: scores[metric] for metric in ("ods", "ois", "ap")}
        trackers[name] = (trained_network(weights, settings), settings.precision, known)
    write_table(table, time_tracking(trackers, images, n_rounds))


run(time_trackers)
