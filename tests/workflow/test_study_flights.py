"""Studies of flights and budgets, scores of the shipped tracker, in the tiny configuration."""

from pathlib import Path

import pandas as pd
import pytest
import yaml
from runs import parsed, run_snakemake

from evaluation.lib.choices import PARTS, WHOLE
from evaluation.lib.figures.charts import plot_task
from evaluation.lib.figures.style import new_panel
from evaluation.lib.flight_scores import ROLES
from evaluation.lib.studied import SETS, first_scenes, studied_set
from snowsim.io.scenes import SceneSet


def jobs_of(workflow, name):
    """Jobs of a rule in the plan of a workflow."""
    return [job for job in workflow.dag.jobs if job.rule.name == name]


def test_controls_differ_from_rd_in_labels_or_in_the_flight_s_own_blocks_alone(tmp_path):
    plan = parsed(tmp_path, targets=["results/one_flight/flights.csv", "trackers"])
    sets = {job.wildcards.studied: job for job in jobs_of(plan, "train_studied")}
    assert set(sets) == set(SETS)
    (rd,) = [job for job in jobs_of(plan, "train_tracker") if job.wildcards.training_set == "rd"]
    real = list(rd.input.real)
    assert list(sets["rd"].input.real) == list(sets["rd_full"].input.real) == real
    assert sets["rd_full"].params.data == {**sets["rd"].params.data, "labels": "complete"}
    assert list(sets["rd_sample"].input.real) == [*real, "results/studies/sample_flight.nc"]
    completed = [path.replace("benchmark", "cgan") for path in real]
    assert list(sets["rd_completed"].input.real) == completed
    for job in sets.values():
        for name in ("seed", "replica", "n_epochs"):
            assert job.params[name] == rd.params[name]
        assert job.params.settings == {**rd.params.settings, "n_steps": 4}
    added = {name: (bool(job.input.phy), bool(job.input.cgan)) for name, job in sets.items()}
    assert added["rd_pd"] == added["rd_pd_paper"] == added["pd"] == (True, False)
    assert added["rd_gd"] == added["gd"] == (False, True)
    assert added["rd_pd_gd"] == added["pd_gd"] == (True, True)
    (picked,) = jobs_of(plan, "train_cgan_as_picked")
    assert list(picked.input.scenes) == real
    (completing,) = jobs_of(plan, "train_cgan")
    assert list(completing.input.scenes) == completed


def test_every_flight_is_flown_with_its_own_settings_and_starts_no_flights(tmp_path):
    plan = parsed(tmp_path, targets=["study_flights"])
    seeds = {job.wildcards.flight: job.params.settings["seed"] for job in jobs_of(plan, "fly")}
    assert seeds == {"4000": 4000, "4001": 4001}
    assert not jobs_of(parsed(tmp_path, targets=["results/one_flight/flights.csv"]), "fly")


def test_the_study_of_budgets_trains_every_set_and_chooses_on_validation_scenes(tmp_path):
    plan = parsed(tmp_path, targets=["study_budgets", "trackers"])
    (default,) = [
        job for job in jobs_of(plan, "train_tracker") if job.wildcards.training_set == "rd"
    ]
    trainings = jobs_of(plan, "train_studied")
    assert {job.wildcards.studied for job in trainings} == set(SETS)
    for job in trainings:
        n_steps = int(job.wildcards.n_gradients)
        assert job.params.settings == {**default.params.settings, "n_steps": n_steps}
    for job in jobs_of(plan, "score_studied"):
        assert not [path for path in job.input if "/test/" in path]


def test_the_curve_of_annotation_adds_phy_s_scenes_to_the_first_of_rd(tmp_path):
    plan = parsed(tmp_path, targets=["results/one_flight/annotation.csv"])
    sets = {job.wildcards.studied: job for job in jobs_of(plan, "train_studied")}
    assert set(sets) == {first_scenes(n, with_pd) for n in (2, 4) for with_pd in (False, True)}
    for name, job in sets.items():
        assert job.params.data["n_real"] == studied_set(name).n_real
        assert bool(job.input.phy) == name.endswith("_pd")
        assert not job.input.cgan


def test_a_tracker_without_a_part_of_the_scene_model_differs_in_its_scenes_alone(tmp_path):
    plan = parsed(tmp_path, targets=["results/one_flight/choices.csv", "trackers"])
    (pd_alone,) = {job.params.seed for job in jobs_of(plan, "train_without")}
    (default,) = [
        job for job in jobs_of(plan, "train_tracker") if job.wildcards.training_set == "rd"
    ]
    assert pd_alone == default.params.seed
    trainings = {job.wildcards.part: job for job in jobs_of(plan, "train_without")}
    assert set(trainings) == {WHOLE, *PARTS}
    for part, job in trainings.items():
        assert not job.input.real
        assert {Path(path).parts[2] for path in job.input.phy} == {part}
        assert job.params.settings == {**default.params.settings, "n_steps": 4}
    for job in jobs_of(plan, "score_without"):
        assert not [path for path in job.input if "/test/" in path]


@pytest.mark.study
def test_the_study_of_choices_leaves_a_loss_for_every_part(tmp_path):
    run_snakemake(tmp_path, "--", "study_choices", timeout=3600)
    losses = pd.read_csv(tmp_path / "results/studies/choices/losses.csv")
    assert set(losses["part"]) == set(PARTS)
    assert losses[["mean", "low", "high", "flight_1104", "flight_1105"]].notna().all(axis=None)


@pytest.mark.study
def test_the_study_of_budgets_leaves_a_table_that_the_chart_is_drawn_from(tmp_path):
    run_snakemake(tmp_path, "--", "study_budgets", timeout=3600)
    table = pd.read_csv(tmp_path / "results/studies/budgets.csv")
    assert (table[["training_s"]] > 0).all(axis=None)
    costs = table.groupby("training_set")["scenes_s"].max()
    assert costs["rd"] == 0 < costs["pd"] < costs["gd"]
    assert costs["rd_gd_picked"] > 0
    _, ax = new_panel()
    plot_task(ax, table)
    assert len(ax.texts) == len(SETS)
    depths = pd.read_csv(tmp_path / "results/studies/budgets_depths.csv")
    assert (depths["n_found"] <= depths["n_true"]).all()


@pytest.mark.study
def test_the_study_of_compute_leaves_a_row_for_every_training(tmp_path):
    run_snakemake(tmp_path, "--", "study_compute", timeout=3600)
    table = pd.read_csv(tmp_path / "results/studies/compute.csv")
    assert table[["n_scenes", "width", "n_gradients"]].values.tolist() == [[2, 2, 4], [7, 3, 6]]
    assert table["ods"].between(0, 1).all()
    renders = tmp_path / "results/studies/compute"
    more, few = (SceneSet(sorted(renders.glob(f"{n}/phy/*.nc"))) for n in (7, 2))
    with more, few:
        assert [scene.name for scene in more][:2] == [scene.name for scene in few]
        assert len(more) == 7


@pytest.mark.study
def test_two_small_flights_run_to_their_table(tmp_path):
    run_snakemake(tmp_path, "--", "study_flights", timeout=3600)
    worth = pd.read_csv(tmp_path / "results/studies/flights/worth.csv")
    assert len(worth) == 3 * (len(ROLES) + len(SETS))
    assert worth[["flight_4000", "flight_4001", "low", "high"]].notna().all(axis=None)
    depths = pd.read_csv(tmp_path / "results/studies/flights/depths.csv")
    assert set(depths["training_set"]) == set(SETS)
    assert (depths["n_found"] <= depths["n_true"]).all()
    scores = pd.read_csv(tmp_path / "results/studies/flights/scores.csv")
    assert len(scores) == len(SETS) * 2 * scores["replica"].nunique()


@pytest.mark.study
def test_the_study_of_annotation_leaves_its_curve(tmp_path):
    run_snakemake(tmp_path, "--", "study_annotation", timeout=3600)
    curve = pd.read_csv(tmp_path / "results/studies/annotation/curve.csv")
    assert len(curve) == 2 * 2 * 2
    assert (tmp_path / "results/figures/annotation.svg").exists()


@pytest.mark.study
def test_the_tracker_is_trained_scored_on_unseen_flights_and_shipped_with_its_scores(tmp_path):
    run_snakemake(tmp_path, "--", "transfer", timeout=1800)
    table = pd.read_csv(tmp_path / "results/tables/transfer.csv")
    assert table[["ods", "own_ods"]].stack().between(0, 1).all()
    of_snow = pd.read_csv(tmp_path / "results/tables/transfer_accumulation.csv")
    assert set(of_snow["tracker"]) == {"universal", "baseline", "sato", "true horizons"}
    run_snakemake(tmp_path, "--", "pretrained", timeout=600)
    card = yaml.safe_load((tmp_path / "results/shipped/universal.json").read_text())
    assert [row["flight"] for row in card["scores"]] == ["noisy", "mean"]
