"""Studies of flights and budgets, scores of the shipped tracker, in the tiny configuration."""

from pathlib import Path

import pandas as pd
import pytest
import yaml
from runs import parsed, run_snakemake

from evaluation.lib.choices import PARTS, WHOLE
from evaluation.lib.figures.charts import plot_task
from evaluation.lib.figures.style import new_panel
from evaluation.lib.flight_scores import PAIRS


def jobs_of(workflow, name):
    """Jobs of a rule in the plan of a workflow."""
    return [job for job in workflow.dag.jobs if job.rule.name == name]


def test_controls_differ_from_rd_in_labels_or_in_the_flight_s_own_blocks_alone(tmp_path):
    plan = parsed(tmp_path, targets=["results/one_flight/flights.csv"])
    controls = {job.wildcards.control: job for job in jobs_of(plan, "train_control")}
    (rd,) = [job for job in jobs_of(plan, "train_tracker") if job.wildcards.training_set == "rd"]
    assert controls["rd_full"].params.data == {**rd.params.data, "labels": "complete"}
    assert controls["rd_own"].params.data == rd.params.data
    real = list(rd.input.real)
    assert list(controls["rd_full"].input.real) == real
    assert list(controls["rd_own"].input.real) == [*real, "results/one_flight/own.nc"]
    for control in controls.values():
        for name in ("seed", "replica", "settings", "n_epochs"):
            assert control.params[name] == rd.params[name]


def test_every_flight_is_flown_with_its_own_settings_and_starts_no_flights(tmp_path):
    plan = parsed(tmp_path, targets=["study_flights"])
    seeds = {job.wildcards.flight: job.params.settings["seed"] for job in jobs_of(plan, "fly")}
    assert seeds == {"3000": 3000, "3001": 3001}
    assert not jobs_of(parsed(tmp_path, targets=["results/one_flight/flights.csv"]), "fly")


def test_a_training_of_the_study_of_budgets_differs_in_its_number_of_gradients_alone(tmp_path):
    plan = parsed(tmp_path, targets=["study_budgets", "trackers"])
    (default,) = [
        job for job in jobs_of(plan, "train_tracker") if job.wildcards.training_set == "rd"
    ]
    trainings = jobs_of(plan, "train_budget")
    assert {job.wildcards.training_set for job in trainings} == {"rd", "pd", "gd", "rd_pd"}
    for job in trainings:
        n_steps = int(job.wildcards.n_gradients)
        assert job.params.settings == {**default.params.settings, "n_steps": n_steps}
        for name in ("seed", "replica", "data", "device"):
            assert job.params[name] == default.params[name]
    # Test scenes choose nothing.
    (tabulate,) = jobs_of(plan, "tabulate_budgets")
    assert not [path for path in tabulate.input if "/test/" in path]


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
    assert losses[["mean", "low", "high", "flight_1101", "flight_1102"]].notna().all(axis=None)


@pytest.mark.study
def test_the_study_of_budgets_leaves_a_table_that_the_chart_is_drawn_from(tmp_path):
    run_snakemake(tmp_path, "--", "study_budgets", timeout=1800)
    table = pd.read_csv(tmp_path / "results/studies/budgets.csv")
    assert (table[["training_s"]] > 0).all(axis=None)
    costs = table.groupby("training_set")["scenes_s"].max()
    assert costs["rd"] == 0 < costs["pd"] < costs["gd"]
    _, ax = new_panel()
    plot_task(ax, table)
    assert len(ax.lines) == 4


@pytest.mark.study
def test_two_small_flights_run_to_their_table(tmp_path):
    run_snakemake(tmp_path, "--", "study_flights", timeout=3600)
    worth = pd.read_csv(tmp_path / "results/studies/flights/worth.csv")
    sets = {name for pair in PAIRS for name in pair}
    assert len(worth) == 3 * (len(PAIRS) + len(sets))
    assert worth[["flight_3000", "flight_3001", "low", "high"]].notna().all(axis=None)


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
