"""Edge counts and picks of a trained tracker on a set of scenes."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
import torch

from lib.score_tables import counts_by_image
from snowsim.io.models import read_model
from snowsim.metrics.edges import THRESHOLDS, match_counts, score, suppress
from snowsim.metrics.picks import layer_rows
from snowsim.tracker import OUTPUTS, Settings, pick_layers, track, trained_network


@dataclass(frozen=True)
class Tracker:
    """A trained network and the settings it was trained with."""

    network: torch.nn.Module
    settings: Settings

    def track(self, image):
        """Probabilities of layers as from `snowsim.tracker.track`, in the training's precision."""
        return track(self.network, image, precision=self.settings.precision)


def read_tracker(path, device="cpu"):
    """The `Tracker` whose weights a file holds."""
    weights, metadata = read_model(path, {"kind": "tracker"})
    settings = Settings(**metadata["settings"])
    return Tracker(trained_network(weights, settings, device=device), settings)


def count_edges(tracker, scenes, outputs=OUTPUTS):
    """Table of edge counts of some outputs, and a list of the fused output's probabilities.

    The table has columns `scene, output, threshold` and the counts of `match_counts`.
    """
    tables = []
    fused = []
    for scene in scenes:
        probabilities = dict(zip(OUTPUTS, tracker.track(scene.image), strict=True))
        for output in outputs:
            tables.append(count_output(probabilities[output], scene, output))
        fused.append(probabilities["fuse"])
    return pd.concat(tables), fused


def count_output(probability, scene, output):
    """Table of edge counts of one output on one scene."""
    edges = suppress(probability, where=scene.name)
    counts = match_counts(edges, scene.mask(), THRESHOLDS, where=scene.name)
    keys = {"scene": scene.name, "output": output, "threshold": THRESHOLDS}
    return pd.DataFrame(keys | counts)


def pick_scenes(scenes, fused, counts):
    """Table of `layer_rows` of all scenes, picked at the threshold with the best F of the set.

    `fused` and `counts` come from `count_edges`. Three columns are added: `scene`,
    `first_thickness_bins`, the mean thickness of its first slab, and `threshold`.
    """
    of_fused = counts_by_image(counts[counts["output"] == "fuse"])
    threshold = score(of_fused, THRESHOLDS)["ods_threshold"]
    tables = []
    for scene, probability in zip(scenes, fused, strict=True):
        picks = pick_layers(probability, threshold=threshold, where=scene.name)
        first_slab = np.diff(scene.layer_bins[:2], axis=0)
        thickness = float(np.nanmean(first_slab)) if np.isfinite(first_slab).any() else np.nan
        rows = layer_rows(picks, scene.layer_bins)
        rows = rows.assign(scene=scene.name, first_thickness_bins=thickness, threshold=threshold)
        tables.append(rows)
    return pd.concat(tables)
