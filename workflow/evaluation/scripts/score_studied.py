"""Fused edge scores of the trainings of one set, and the share of layers found by depth."""

import numpy as np
import pandas as pd
from main_path import job, progress

from lib.score_tables import counts_by_image
from lib.tracker_scores import count_edges, pick_scenes, read_tracker
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet
from snowsim.metrics.edges import METRICS, score

with (
    job(snakemake),
    SceneSet(snakemake.input.scenes) as scenes,
    SceneSet(snakemake.input.validation) as validation,
):
    scores = []
    depths = []
    for replica, path in enumerate(progress(snakemake.input.networks, "trackers")):
        tracker = read_tracker(path).calibrated(validation)
        counts, fused = count_edges(tracker, scenes, ["fuse"])
        found = score(counts_by_image(counts, "fuse"))
        labels = snakemake.params.labels | {"replica": replica}
        scores.append(labels | {metric: found[metric] for metric in METRICS})
        # False layers have no depth of a true one.
        rows = pick_scenes(scenes, fused, counts).query("n_true > 0")
        step_bins = snakemake.params.depth_step_bins
        step = np.floor(rows["depth_bins"] / step_bins).astype(int)
        rows = rows.assign(depth_from_bins=np.maximum(step, 0) * step_bins)
        sums = rows.groupby("depth_from_bins")[["n_true", "n_found", "n_layers"]].sum()
        depths.append(sums.reset_index().assign(**labels))
    write_table(snakemake.output.scores, pd.DataFrame(scores))
    write_table(snakemake.output.depths, pd.concat(depths))
