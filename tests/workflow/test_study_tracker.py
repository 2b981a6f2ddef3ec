"""The studies of the tracker in the tiny configuration, and its tables of picks."""

import shutil

import numpy as np
import pandas as pd
import pytest
from result_tables import SETS
from runs import run_snakemake

from snowsim.io.trackers import read_tracker


def test_picks_and_zones_are_tabulated_for_every_training_set(tiny_run):
    picks = pd.read_csv(tiny_run / "results/tables/picks.csv")
    assert set(picks["training_set"]) == set(SETS)
    zones = pd.read_csv(tiny_run / "results/tables/picks_by_zone.csv")
    depths = pd.read_csv(tiny_run / "results/tables/picks_by_depth.csv")
    counts = ["n_layers", "n_true", "n_found", "n_false_layers"]
    expected = picks.groupby("training_set")[counts].sum()
    for parts in (zones, depths):
        whole = parts.groupby("training_set")[counts].sum()
        assert whole.equals(expected)
    scores = pd.read_csv(tiny_run / "results/tables/table3_zones.csv")
    assert scores.groupby(["training_set", "metric"])["n_images"].sum().eq(3).all()
    tests = pd.read_csv(tiny_run / "results/tables/table3_tests.csv")
    assert set(tests["training_set"]) == set(SETS[1:])
    assert (tests["p_holm"] >= tests["p_value"]).all()


@pytest.mark.study
def test_the_studies_of_the_tracker_run_to_their_tables(tiny_run, tmp_path):
    shutil.copytree(tiny_run, tmp_path / "run")
    run_snakemake(tmp_path / "run", "--", "study_tracker", "study_budgets", timeout=3600)
    folder = tmp_path / "run/results/studies/tracker"
    ablation = pd.read_csv(folder / "ablation.csv")
    assert {"default", "masked", "full_labels", "balanced_by_image", "phy_as_printed"} <= set(
        ablation["setting"]
    )
    assert np.isfinite(ablation["mean"]).all()
    worth = pd.read_csv(folder / "worth.csv")
    row = worth.query("training_set == 'pd' and base_training_set == 'rd' and metric == 'ods'")
    assert len(row) == 1
    assert (worth["low"] <= worth["difference"]).all()
    assert (worth["bootstrap_low"] <= worth["bootstrap_high"]).all()
    assert (row["n_images"] == 3).all()
    assert set(worth["base"]) == {"default", "last_part"}
    atlas = pd.read_csv(folder / "atlas.csv")
    assert set(atlas.loc[atlas["status"] == "refused", "panel"]) == {"empty labels", "flat image"}
    budgets = pd.read_csv(tmp_path / "run/results/studies/budgets/tracker.csv", na_filter=False)
    assert list(budgets["change"]) == ["", "", "n_steps 2", "n_steps 2"]
    assert list(budgets["trained_on"]) == ["rd", "pd", "rd", "pd"]
    assert (budgets["core_seconds"] > 0).all()
    for name in ("tracker_ablation", "tracker_worth", "atlas_tracker", "budgets"):
        assert (tmp_path / f"run/results/figures/{name}.svg").stat().st_size > 1000


@pytest.mark.study
def test_the_shipped_tracker_is_trained_scored_on_unseen_flights_and_told_so_in_its_card(
    tiny_run, tmp_path
):
    shutil.copytree(tiny_run, tmp_path / "run")
    run_snakemake(tmp_path / "run", "--", "transfer", timeout=3600)
    results = tmp_path / "run/results"
    scores = pd.read_csv(results / "tables/transfer.csv")
    trackers = ["universal", "rd", "pd", "rd_pd", "control"]
    assert scores["flight"].tolist() == ["noisy"] * 5 + ["mean"] * 5
    assert scores["tracker"].tolist() == 2 * trackers
    choice = pd.read_csv(results / "transfer/control/noisy/choice.csv")
    assert choice["n_steps"].tolist() == [4, 6]
    assert not (results / "checkpoints").exists() or not any((results / "checkpoints").iterdir())
    # After the study, for the card takes its scores where they are made.
    run_snakemake(tmp_path / "run", "--", "pretrained", timeout=600)
    content, card = read_tracker(results / "shipped/universal.onnx")
    assert [row["flight"] for row in card["scores"]] == ["noisy", "mean"]
    assert len(content) > 1000
