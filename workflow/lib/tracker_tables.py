"""Tables of all trackers: curves, scores by accumulation zone, and errors of picks."""

import numpy as np
import pandas as pd

from lib.score_tables import tracker_intervals
from snowsim.echogram import zone_of
from snowsim.metrics.edges import precision_recall
from snowsim.metrics.picks import ZONES, pool_picks
from snowsim.seeding import random_stream

RUN = ["training_set", "replica"]


def fused_curves(counts, training_sets):
    """Precision and recall of the fused output at every threshold, means over replicas.

    `counts` come from `counts_of_runs`.
    """
    frames = []
    for training_set in training_sets:
        curves = [precision_recall(images) for images in counts[training_set, "fuse"]]
        frame = pd.DataFrame(
            {
                "training_set": training_set,
                "precision": np.mean([curve["precision"] for curve in curves], axis=0),
                "recall": np.mean([curve["recall"] for curve in curves], axis=0),
            }
        )
        frames.append(frame)
    return pd.concat(frames)


def intervals_by_zone(counts, training_sets, zones, *, n_bootstrap, seed):
    """`tracker_intervals` of the fused output for the images of every zone.

    `zones` holds the number of each image's zone, -1 for none.
    """
    tables = []
    for number, name in enumerate(ZONES, start=-1):
        places = np.flatnonzero(np.asarray(zones) == number)
        if not places.size:
            continue
        inside = {}
        for training_set in training_sets:
            replicas = counts[training_set, "fuse"]
            inside[training_set, "fuse"] = [[images[p] for p in places] for images in replicas]
        rng = random_stream(seed, "tabulate_tracker_zones", number)
        table = tracker_intervals(
            inside, training_sets, outputs=["fuse"], n_bootstrap=n_bootstrap, rng=rng
        )
        table.insert(0, "zone", name)
        tables.append(table)
    return pd.concat(tables)


def rows_of_picks(tables, runs, zone_edge_bins, depth_step_bins):
    """Rows of picks of all runs, with the zone of each scene and the depth step of each layer."""
    found = []
    for (training_set, replica), table in zip(runs, tables, strict=True):
        zone = zone_of(table["first_thickness_bins"], zone_edge_bins)
        # A false layer above the surface counts with the shallowest layers.
        step = np.maximum(np.floor(table["depth_bins"] / depth_step_bins), 0).astype(int)
        rows = table.assign(
            training_set=training_set,
            replica=replica,
            zone=[ZONES[number + 1] for number in zone],
            depth_from_bins=step * depth_step_bins,
        )
        found.append(rows)
    return pd.concat(found)


def picks_by_zone(rows, bin_size_m):
    """Errors of picks of every run by zone, zones from none to very high."""
    table = pool_picks(rows, [*RUN, "zone"], bin_size_m=bin_size_m)
    order = table["zone"].map(ZONES.index)
    return table.assign(order=order).sort_values([*RUN, "order"]).drop(columns="order")


def picks_by_depth(rows, bin_size_m):
    """Errors of picks of every run by depth below the surface."""
    table = pool_picks(rows, [*RUN, "depth_from_bins"], bin_size_m=bin_size_m)
    return table.sort_values([*RUN, "depth_from_bins"])
