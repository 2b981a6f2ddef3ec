import pandas as pd
from edge_counts import image_counts
from numpy.testing import assert_allclose

from lib.score_tables import similarity_table, ssim_against_depth, tracker_intervals
from snowsim.constants import OUTPUTS


def test_table2_holds_min_mean_and_max_and_ssim_against_depth_ends_with_the_shallowest_scene():
    rows = [
        ("phy", 10.0, 5.0, 0.1),
        ("phy", 30.0, 7.0, 0.2),
        ("cgan", 1.0, 20.0, 0.5),
        ("cgan", 3.0, 30.0, 0.7),
    ]
    images = pd.DataFrame(rows, columns=["method", "rmse", "psnr", "ssim"]).assign(
        scene=["a", "b", "a", "b"]
    )
    table = similarity_table(images).set_index(["metric", "statistic"])
    assert list(table.columns) == ["cgan", "phy"]
    assert_allclose(table.loc["rmse", "phy"], [10, 20, 30])
    assert_allclose(table.loc["ssim", "cgan"], [0.5, 0.6, 0.7])
    scenes = [("a", n, 0.2) for n in range(4)] + [("b", n, 0.6) for n in range(6)]
    rows = pd.DataFrame(scenes, columns=["scene", "range_bin", "ssim"]).assign(method="phy")
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
