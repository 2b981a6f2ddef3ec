"""Edge counts of trackers on a set of scenes, every output, every threshold; picks from their fused outputs."""

import numpy as np
import pandas as pd
from job import progress, run

from snowsim.io.files import write_table
from snowsim.io.models import read_model
from snowsim.io.scenes import SceneSet
from snowsim.metrics.edges import THRESHOLDS, match_counts, score, suppress
from snowsim.metrics.pick_tables import layer_rows
from snowsim.metrics.picks import pick_layers
from snowsim.tracker import OUTPUTS, Settings, track, trained_network


def pick(scenes, edges, threshold):
    """Rows of every layer of every scene, with the scene's name and the thickness of its first slab."""
    tables = []
    for scene, suppressed in zip(scenes, edges, strict=True):
        picks = pick_layers(suppressed, threshold=threshold, where=scene.name)
        first = np.diff(scene.layer_bins[:2], axis=0)
        first = float(np.nanmean(first)) if np.isfinite(first).any() else np.nan
        rows = layer_rows(picks, scene.layer_bins)
        tables.append(
            rows.assign(scene=scene.name, first_thickness_bins=first, threshold=threshold)
        )
    return pd.concat(tables)


def evaluate(scenes, path_to_network, path_to_counts, path_to_picks, device, outputs):
    """Score one tracker; no picks are written where there is no path to them."""
    weights, metadata = read_model(path_to_network, {"kind": "tracker"})
    settings = Settings(**metadata["settings"])
    network = trained_network(weights, settings, device=device)
    tables, fused, fused_counts = [], [], []
    for scene in progress(scenes, "edge scores"):
        probabilities = track(network, scene.image, precision=settings.precision)
        for output in outputs:
            edges = suppress(probabilities[OUTPUTS.index(output)], where=scene.name)
            counts = match_counts(edges, scene.mask(), THRESHOLDS, where=scene.name)
            tables.append(
                pd.DataFrame(
                    {"scene": scene.name, "output": output, "threshold": THRESHOLDS, **counts}
                )
            )
            if output == "fuse" and path_to_picks is not None:
                fused.append(edges.astype(np.float32))
                fused_counts.append(counts)
    if path_to_picks is not None:
        # The threshold of the best F of the set, as for ODS.
        threshold = score(fused_counts, THRESHOLDS)["ods_threshold"]
        write_table(path_to_picks, pick(scenes, fused, threshold))
    write_table(path_to_counts, pd.concat(tables))


def score_trackers(scenes, networks, counts, picks=(), *, device, outputs=OUTPUTS):
    files = zip(networks, counts, picks or [None] * len(counts), strict=True)
    with SceneSet(scenes) as test_scenes:
        for paths in files:
            evaluate(test_scenes, *paths, device, outputs)


run(score_trackers)
