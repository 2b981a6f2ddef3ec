"""Scores of trackers on another flight: edges, picks and calibration of the fused output."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
import torch
from torch.nn import functional

from snowsim.metrics.edges import suppress
from snowsim.metrics.pick_tables import layer_rows
from snowsim.metrics.picks import pick_layers
from snowsim.tracker.calibration import (
    Calibration,
    edge_scores,
    fused_logits,
    reliability,
    ridges_of,
)


@dataclass(frozen=True, eq=False)
class Compared:
    """A tracker that is compared: its network, and what it was calibrated to elsewhere."""

    name: str
    network: torch.nn.Module
    calibration: Calibration


def logits_at(network, image, scale):
    """Fused logits on the image's own pixels, tracked at another size: `scale` (bin, line).

    What the network was not trained for is brought to its range bins and line spacing, and back.
    """
    if scale == (1, 1):
        return fused_logits(network, image)
    size = tuple(max(16, round(n * factor)) for n, factor in zip(image.shape, scale, strict=True))
    given = torch.from_numpy(image)[None, None]
    smaller = functional.interpolate(given, size=size, mode="bilinear", antialias=True)
    logits = torch.from_numpy(fused_logits(network, smaller[0, 0].numpy()))[None, None]
    return functional.interpolate(logits, size=image.shape, mode="bilinear")[0, 0].numpy()


def followed(probability, threshold, *, where):
    """Picks (layer, range_line) of a map of probability: the one place that links them here."""
    return pick_layers(suppress(probability), threshold=threshold, where=where)


def score_tracker(tracker, scenes, scale):
    """A row of `scores` and the `reliability` table of a tracker on annotated scenes.

    Returns
    -------
    scores : dict
        `tracker`; `ods`, `ois`, `ap`; at its `threshold`, of picks: `recall`, `precision` and `f`
        within 2 bins, `mean_error_bins` of picks that belong to a layer, `missed_share` and
        `false_share`, layers missed and false pieces, of the number of true layers; `deviation` of
        its reliability.
    curve : pandas.DataFrame
        `tracker, said, seen, n_pixels`, a row a class.
    """
    logits = [logits_at(tracker.network, scene.image, scale) for scene in scenes]
    probability = [tracker.calibration.probability(each) for each in logits]
    edges = edge_scores(probability, scenes)
    ridges = ridges_of(logits, scenes)
    curve = reliability(tracker.calibration.probability(ridges.logits), ridges.hits)
    scores = {name: edges[name] for name in ("ods", "ois", "ap")}
    row = {"tracker": tracker.name, **scores, "threshold": tracker.calibration.threshold}
    row |= pick_scores(probability, scenes, tracker.calibration.threshold)
    row["deviation"] = curve.deviation
    return row, pd.DataFrame({"tracker": tracker.name, **vars(curve)})


def pick_scores(probability, scenes, threshold):
    """Scores of followed picks, pooled over scenes, by name; see `score_tracker`."""
    n_picked = 0
    tables = []
    for each, scene in zip(probability, scenes, strict=True):
        picks = followed(each, threshold, where=scene.name)
        n_picked += int(np.isfinite(picks).sum())
        tables.append(layer_rows(picks, scene.layer_bins))
    sums = pd.concat(tables).sum()
    recall = sums["n_within"] / sums["n_true"]
    precision = sums["n_within"] / max(n_picked, 1)
    return {
        "recall": recall,
        "precision": precision,
        "f": 2 * recall * precision / max(recall + precision, 1e-12),
        "mean_error_bins": sums["absolute_error"] / max(sums["n_found"], 1),
        "missed_share": sums["n_missed_layers"] / sums["n_layers"],
        "false_share": sums["n_false_layers"] / sums["n_layers"],
        "n_layers": int(sums["n_layers"]),
    }
