import numpy as np
import pandas as pd
from edge_counts import image_counts
from numpy.testing import assert_allclose

from lib.score_tables import similarity_table, ssim_against_depth, tracker_intervals
from snowsim.constants import OUTPUTS


def test_table2_holds_min_mean_and_max_and_ssim_against_depth_ends_with_the_shallowest_scene():
    images = pd.DataFrame({"method": ["phy", "phy", "cgan", "cgan"], "scene": [*"abab"]})
    images["rmse"] = [10, 30, 1, 3]
    images["psnr"] = [5, 7, 20, 30]
    images["ssim"] = [0.1, 0.2, 0.5, 0.7]
    table = similarity_table(images).set_index(["metric", "statistic"])
    assert_allclose(table.loc["rmse", "phy"], [10, 20, 30])
    assert_allclose(table.loc["ssim", "cgan"], [0.5, 0.6, 0.7])
    rows = pd.DataFrame({"scene": [*"aaaabbbbbb"], "range_bin": [*range(4), *range(6)]})
    rows["ssim"] = np.where(rows["scene"] == "a", 0.2, 0.6)
    rows["method"] = "phy"
    table = ssim_against_depth(rows, 3)
    assert list(table["range_bin"]) == [0, 1, 2, 3]
    assert_allclose(table["ssim"], 0.4)
    assert_allclose(table["ssim_smooth"], 0.4)


def test_equal_sets_differ_by_nothing_and_a_better_one_does(rng):
    base, better = ([image_counts(share, 30, rng=rng) for _ in range(2)] for share in (0.6, 0.9))
    counts = {
        (s, output): c
        for s, c in [("rd", base), ("rd_gd", base), ("rd_pd", better)]
        for output in OUTPUTS
    }
    intervals = tracker_intervals(counts, ["rd", "rd_gd", "rd_pd"], n_bootstrap=200, rng=rng)
    same = intervals[intervals["training_set"] == "rd_gd"]
    assert_allclose(same[["difference", "difference_low", "difference_high"]], 0)
    ods = intervals[(intervals["training_set"] == "rd_pd") & (intervals["metric"] == "ods")]
    assert (ods["difference_low"] > 0).all()
