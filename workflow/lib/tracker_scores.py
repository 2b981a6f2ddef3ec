"""Edge counts and picks of a trained tracker on a set of scenes."""

import itertools
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import torch
from scipy.sparse import coo_array
from scipy.special import expit

from lib.score_tables import counts_by_image
from snowsim.io.models import read_model
from snowsim.metrics.edges import THRESHOLDS, match_counts, score, suppress, thresholds_of
from snowsim.metrics.picks import layer_rows
from snowsim.tracker import (
    OUTPUTS,
    Settings,
    fit_logits,
    logits_of,
    pick_layers,
    track,
    trained_network,
)

N_CALIBRATING = 40


@dataclass(frozen=True)
class Tracker:
    """A trained network, the settings it was trained with, and the calibration of its outputs.

    `calibration` has the offset and the temperature of each of `OUTPUTS` by name; None without.
    """

    network: torch.nn.Module
    settings: Settings
    calibration: dict | None = None

    def track(self, image):
        """Probabilities of layers from each output, in the training's precision and calibrated."""
        if self.calibration is None:
            return self.track_uncalibrated(image)
        logits = self.logits(image)
        offset, temperature = np.transpose([self.calibration[name] for name in OUTPUTS])
        return expit((logits - offset[:, None, None]) / temperature[:, None, None])

    def track_uncalibrated(self, image):
        """Probabilities of layers as from `snowsim.tracker.track`, in the training's precision."""
        return track(self.network, image, precision=self.settings.precision)

    def logits(self, image):
        """Logits of layers as from `snowsim.tracker.logits_of`, in the training's precision."""
        return logits_of(self.network, image, precision=self.settings.precision)

    def calibrated(self, scenes):
        """The tracker with each output calibrated by `fit_logits` on fully annotated scenes.

        Without, suppression would favour the training whose probabilities happen to be smooth. Two
        numbers an output need no more than `N_CALIBRATING` scenes, whose logits are kept in memory.
        """
        scenes = list(itertools.islice(scenes, N_CALIBRATING))
        by_scene = [self.logits(scene.image) for scene in scenes]
        fitted = {
            name: fit_logits([logits[i] for logits in by_scene], scenes)
            for i, name in enumerate(OUTPUTS)
        }
        return replace(self, calibration=fitted)


def read_tracker(path, device="cpu"):
    """The `Tracker` whose weights a file holds."""
    weights, metadata = read_model(path, {"kind": "tracker"})
    settings = Settings(**metadata["settings"])
    return Tracker(trained_network(weights, settings, device=device), settings)


def count_edges(tracker, scenes, outputs=OUTPUTS, *, at=None, as_published=False):
    """Table of edge counts of some outputs, and a list of the fused output's probabilities.

    The table has columns `grid, output, scene, threshold` and the counts of `match_counts`. Grids
    are `quantiles`, the `thresholds_of` all scenes; `validation`, the threshold of each output in
    the dict `at`, if given; and `published`, if asked for, of
    probabilities before calibration.
    """
    edges = {output: [] for output in outputs}
    annotated = []
    fused = []
    tables = []
    for scene in scenes:
        annotated.append((scene.name, scene.mask()))
        probabilities = dict(zip(OUTPUTS, tracker.track(scene.image), strict=True))
        fused.append(probabilities["fuse"])
        if as_published:
            maps = tracker.track_uncalibrated(scene.image)
            uncalibrated = dict(zip(OUTPUTS, maps, strict=True))
        for output in outputs:
            found = suppress(probabilities[output], added_curvature=0, where=scene.name)
            # Most pixels are 0: the maps of a whole set take little memory.
            edges[output].append(coo_array(found))
            if as_published:
                found = suppress(uncalibrated[output], where=scene.name)
                tables.append(count_output(found, *annotated[-1], THRESHOLDS, "published", output))
    for output in outputs:
        thresholds = thresholds_of([found.data for found in edges[output]])
        grid = ["quantiles"] * thresholds.size
        if at is not None:
            thresholds = np.append(thresholds, at[output])
            grid.append("validation")
        for found, (name, mask) in zip(edges[output], annotated, strict=True):
            tables.append(count_output(found.toarray(), name, mask, thresholds, grid, output))
    return pd.concat(tables), fused


def count_output(edges, name, mask, thresholds, grid, output):
    """Table of edge counts of one output on one scene."""
    counts = match_counts(edges, mask, thresholds)
    keys = {"grid": grid, "output": output, "scene": name, "threshold": thresholds}
    return pd.DataFrame(keys | counts)


def best_thresholds(counts, outputs=OUTPUTS):
    """Threshold with the best F of a table of `count_edges`, by output."""
    best = {}
    for output in outputs:
        images = counts_by_image(counts, output)
        best[output] = score(images, images[0]["threshold"])["ods_threshold"]
    return best


def pick_scenes(scenes, fused, counts):
    """Table of `layer_rows` of all scenes, picked at the threshold with the best F of the set.

    `fused` and `counts` come from `count_edges`. Three columns are added: `scene`,
    `first_thickness_bins`, the mean thickness of its first slab, and `threshold`.
    """
    threshold = best_thresholds(counts, ["fuse"])["fuse"]
    tables = []
    for scene, probability in zip(scenes, fused, strict=True):
        picks = pick_layers(probability, threshold=threshold, where=scene.name)
        first_slab = np.diff(scene.layer_bins[:2], axis=0)
        thickness = float(np.nanmean(first_slab)) if np.isfinite(first_slab).any() else np.nan
        rows = layer_rows(picks, scene.layer_bins)
        rows = rows.assign(scene=scene.name, first_thickness_bins=thickness, threshold=threshold)
        tables.append(rows)
    return pd.concat(tables)
