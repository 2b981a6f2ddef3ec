"""Zones and depths of the tracker's tables divide what is scored and lose nothing."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from edge_counts import image_counts
from numpy.testing import assert_allclose
from scipy.ndimage import gaussian_filter
from toy_scenes import toy_scenes, with_ridges

from lib import tracker_scores
from lib.score_tables import counts_by_image, tracker_intervals
from lib.tracker_scores import Tracker, best_thresholds, count_edges, pick_scenes
from lib.tracker_tables import intervals_by_zone, picks_by_depth, picks_by_zone, rows_of_picks
from snowsim.constants import OUTPUTS
from snowsim.metrics.edges import score
from snowsim.metrics.picks import SUMS
from snowsim.seeding import random_stream
from snowsim.tracker import Settings

SETS = ["rd", "rd_gd"]
RUNS = [(name, replica) for name in SETS for replica in (0, 1)]


@pytest.fixture
def counts(rng):
    """Counts of the fused output: two sets, two replicas, six images, three thresholds."""
    return {(name, "fuse"): [image_counts(0.6, 6, rng=rng) for _ in range(2)] for name in SETS}


def test_scores_of_a_zone_are_those_of_its_images_alone(counts):
    zones = [2, 0, 2, -1, 0, 2]
    table = intervals_by_zone(counts, SETS, zones, n_bootstrap=20, seed=1)
    assert list(dict.fromkeys(table["zone"])) == ["none", "shallow", "high"]
    inside = {
        key: [[images[place] for place in (0, 2, 5)] for images in of_key]
        for key, of_key in counts.items()
    }
    rng = random_stream(1, "tabulate_tracker_zones", 2)
    alone = tracker_intervals(inside, SETS, outputs=["fuse"], n_bootstrap=20, rng=rng)
    found = table[table["zone"] == "high"].drop(columns="zone").reset_index(drop=True)
    pd.testing.assert_frame_equal(found, alone)


def test_zones_and_depths_hold_every_layer_once(rng):
    depths = np.array([-3.0, 0, 19.9, 20, 47])
    sums = dict.fromkeys(SUMS, 1)
    picks = [
        pd.DataFrame(
            {
                "depth_bins": depths,
                "first_thickness_bins": rng.choice([5.0, 25, 45, np.nan], 5),
                **sums,
            }
        )
        for _ in RUNS
    ]
    rows = rows_of_picks(picks, RUNS, zone_edge_bins=[0, 10, 20, 30, 40], depth_step_bins=20)
    assert rows["depth_from_bins"].tolist() == len(RUNS) * [0, 0, 0, 20, 40]
    for table in (picks_by_zone(rows, 0.04), picks_by_depth(rows, 0.04)):
        assert table.groupby(["training_set", "replica"])["n_layers"].sum().tolist() == [5, 5, 5, 5]


def test_a_tracker_that_knows_the_layers_finds_and_picks_them_all():
    def track(image):
        return np.repeat(np.float32(image[None] / 255), len(OUTPUTS), axis=0)

    scenes = list(map(with_ridges, toy_scenes(2)))
    counts, fused = count_edges(SimpleNamespace(track=track), scenes, ["side_1", "fuse"])
    rows = pick_scenes(scenes, fused, counts)
    assert not rows[["n_missed_layers", "n_false_layers"]].to_numpy().any()
    # Log-odds fall in straight lines on either side of a layer; a parabola through three rows of
    # them errs most where one lies .3 rows off, by .09.
    assert (rows["absolute_error"] < 0.2 * rows["n_found"]).all()
    at = best_thresholds(counts, ["side_1", "fuse"])
    known = SimpleNamespace(track=track, track_uncalibrated=track)
    both, _ = count_edges(known, scenes, ["side_1", "fuse"], at=at, as_published=True)
    assert both.groupby("grid").size().to_dict() == {
        "published": 4 * 99,
        "quantiles": 4 * 99,
        "validation": 4,
    }
    first = [np.diff(scene.layer_bins[:2], axis=0).mean() for scene in scenes]
    assert rows["first_thickness_bins"].unique().tolist() == pytest.approx(first)


@pytest.mark.parametrize(("scale", "shift"), [(1 / 4, 0), (4, 0), (1, -4), (1, 4), (4, 4)])
def test_scores_do_not_depend_on_how_sharp_or_high_probabilities_are(scale, shift, monkeypatch):
    scenes = toy_scenes(2)

    def scores(scale, shift):
        def logits(network, image, *, precision):
            blurred = [gaussian_filter(image / 255, width) for width in (0.5, 1, 1, 2, 3, 1.5)]
            return np.float32(scale * (12 * np.array(blurred) - 5) + shift)

        monkeypatch.setattr(tracker_scores, "logits_of", logits)
        tracker = Tracker(None, Settings()).calibrated(scenes)
        counts, _ = count_edges(tracker, scenes, ["side_2", "fuse"])
        images = [counts_by_image(counts, output) for output in ("side_2", "fuse")]
        found = [score(each, each[0]["threshold"]) for each in images]
        return [each[name] for each in found for name in ("ods", "ois", "ap")]

    # Offset and temperature are found to some 1e-5; maps that differ by as much have other
    # thresholds, and a pixel may be kept or not.
    assert_allclose(scores(scale, shift), scores(1, 0), atol=1e-3)
