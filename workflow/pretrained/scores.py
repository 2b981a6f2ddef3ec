"""Scores of a tracker on another flight: of edges in the fused output, and of picks."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
import torch
from scipy.special import logit
from torch.nn import functional

from pretrained.resizing import AS_THEY_ARE, resized, resized_rows
from snowsim.echogram import crossing_layers
from snowsim.io.files import read_table
from snowsim.metrics.edges import score
from snowsim.metrics.picks import layer_rows
from snowsim.tracker import (
    WITHIN_BINS,
    Calibration,
    between_lines,
    confident_pieces,
    edge_counts,
    fused_logits,
    join,
    near_a_layer,
    on_lines,
    pieces_in,
    reliability,
)


@dataclass(frozen=True, eq=False)
class Calibrated:
    """A trained network, and what it was calibrated to elsewhere.

    `confidence` are the coefficients of `snowsim.tracker.confidence`.
    """

    network: torch.nn.Module
    calibration: Calibration
    confidence: tuple


def read_calibration(path):
    """The `Calibration` that a table of one row holds."""
    return Calibration(**read_table(path).iloc[0].to_dict())


def read_confidence(path):
    """Coefficients of `snowsim.tracker.confidence` in a table of one row, (offset, near, far)."""
    return tuple(read_table(path).loc[0, ["offset", "near", "far"]])


@dataclass(frozen=True, eq=False)
class Picks:
    """Layers followed through a scene: range bins, and how sure each is, (layer, range_line)."""

    bins: np.ndarray
    sure: np.ndarray


def on_pixels(logits, shape):
    """Logits on the pixels of an image that was tracked at another size."""
    given = torch.from_numpy(logits)[None, None]
    return functional.interpolate(given, size=shape, mode="bilinear")[0, 0].numpy()


def pieces_of(logits, calibration):
    """Pieces of layers in a map of logits, linked as `snowsim track` links them, downwards."""
    log_odds = (logits - calibration.offset) / calibration.temperature
    return join(pieces_in(log_odds, float(logit(calibration.threshold))))


def followed(logits, tracker, shape):
    """`Picks` on the pixels of an image, of the logits of a tracker that may be of another size."""
    n_rows, n_lines = logits.shape
    lines = np.arange(n_lines)
    own_lines = np.linspace(0, n_lines - 1, shape[1])
    bins = []
    sure = []
    found = pieces_of(logits, tracker.calibration)
    for piece, of_piece in confident_pieces(found, n_lines, tracker.confidence):
        own_row = resized_rows(on_lines(piece, piece.row, lines), n_rows, shape[0])
        bins.append(between_lines(own_row, own_lines))
        sure.append(between_lines(on_lines(piece, of_piece, lines), own_lines))
    bins = np.array(bins).reshape(-1, shape[1])
    bins[crossing_layers(bins)] = np.nan
    return Picks(bins, np.array(sure).reshape(-1, shape[1]))


def reliability_of(picks, scenes, scale=AS_THEY_ARE):
    """`Reliability` of the confidence of picks on scenes with every layer annotated.

    Hits lie within 2 bins of the size that the tracker saw.
    """
    sure = []
    hits = []
    for each, scene in zip(picks, scenes, strict=True):
        picked = np.isfinite(each.bins)
        line = np.nonzero(picked)[1]
        sure.append(each.sure[picked])
        hits.append(near_a_layer(each.bins[picked], line, scene, WITHIN_BINS / scale[0]))
    return reliability(np.concatenate(sure), np.concatenate(hits))


def score_tracker(tracker, scenes, scale):
    """Scores of a tracker on annotated scenes, by name.

    `scale` (bin, line) brings them to the range bins and line spacing that it was trained on.
    `ods, ois, ap`; of picks, linked at its `threshold`: `recall`, `precision` and `f` within 2
    bins, `mean_error_bins` of picks that belong to a layer, `missed_share` and `false_share`,
    layers missed and false pieces, of the number of true layers; `deviation` of the reliability of
    its confidence.
    """
    probability = []
    picks = []
    for scene in scenes:
        logits = fused_logits(tracker.network, resized(scene.image, scale))
        on_its_own = on_pixels(logits, scene.image.shape)
        probability.append(tracker.calibration.probability(on_its_own))
        picks.append(followed(logits, tracker, scene.image.shape))
    edges = score(*edge_counts(probability, scenes))
    scores = {name: edges[name] for name in ("ods", "ois", "ap")}
    scores["threshold"] = tracker.calibration.threshold
    scores |= pick_scores(picks, scenes)
    scores["deviation"] = reliability_of(picks, scenes, scale).deviation
    return scores


def pick_scores(picks, scenes):
    """Scores of `Picks`, pooled over scenes, by name; see `score_tracker`."""
    n_picked = 0
    tables = []
    for each, scene in zip(picks, scenes, strict=True):
        n_picked += int(np.isfinite(each.bins).sum())
        tables.append(layer_rows(each.bins, scene.layer_bins))
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
