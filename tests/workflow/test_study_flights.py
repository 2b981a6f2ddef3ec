"""The study of flights in the tiny configuration, and what each of its flights is planned to be."""

from itertools import product

import numpy as np
import pandas as pd
import pytest
import yaml
from runs import parsed, refused, run_snakemake, settings

from evaluation.lib import flights
from evaluation.lib.flight_scores import PAIRS

COUNTS = "results/one_flight/counts.parquet"


def jobs_of(workflow, name):
    """Jobs of a rule in the plan of a workflow."""
    return [job for job in workflow.dag.jobs if job.rule.name == name]


def test_a_flight_is_a_whole_run_with_controls_and_few_scenes_for_the_curve(tmp_path):
    plan = parsed(tmp_path, targets=[COUNTS])
    controls = {job.wildcards.control: job for job in jobs_of(plan, "train_flight_control")}
    assert controls["rd_full"].params.data["labels"] == "complete"
    assert any("one_flight/blocks" in path for path in controls["rd_own"].input.real)
    # Of few scenes come statistics, and of these what is drawn, and nothing else of the flight.
    for job in jobs_of(plan, "fit_few"):
        assert job.input.few.startswith("results/one_flight/few/")


def test_trainings_on_scenes_of_the_cgan_have_a_generator_each(tmp_path):
    study = {"studies": {"flights": {"n_trainings": 3}}}
    plan = parsed(tmp_path, targets=[COUNTS], **study)
    seeds = {job.params.seed for job in jobs_of(plan, "train_flight_cgan")}
    assert len(seeds | {job.params.seed for job in jobs_of(plan, "train_cgan")}) == 3
    trained = {
        (job.wildcards.by_generator, job.params.replica)
        for job in jobs_of(plan, "train_by_generator")
    }
    assert trained == set(product(flights.WITH_CGAN, "12"))
    for job in jobs_of(plan, "train_by_generator"):
        folder = f"results/one_flight/cgan/{job.params.replica}/"
        assert all(path.startswith(folder) for path in job.input.cgan)


def test_every_flight_of_the_study_is_flown_with_its_own_settings(tmp_path):
    plan = parsed(tmp_path, targets=["study_flights"])
    flown = {job.wildcards.flight for job in jobs_of(plan, "fly")}
    assert flown == {"2000", "2001"}
    seeds = {job.params.settings["seed"] for job in jobs_of(plan, "set_flight")}
    assert seeds == {2000, 2001}
    # A run of one flight starts no flights.
    assert not jobs_of(parsed(tmp_path, targets=[COUNTS]), "fly")


def test_a_curve_of_more_scenes_than_there_are_is_refused(tmp_path):
    files = settings(tmp_path / "more", "studies: {flights: {curve: [2, 7]}}")
    said = refused(tmp_path / "run", files)
    assert "studies.flights.curve: expected at most benchmark.n_scenes.train = 6, got 7" in said


@pytest.mark.study
def test_two_small_flights_run_to_their_tables_and_figures_and_go_on_where_they_stopped(tmp_path):
    run_snakemake(tmp_path, "--", "study_flights", timeout=3600)
    folder = tmp_path / "results/studies/flights"
    worth = pd.read_csv(folder / "worth.csv")
    n_rows = 3 * len(PAIRS)
    of_all = worth[~worth["run"].str.contains("_of_")]
    assert list(of_all["family"] == "endpoint") == [True] + [False] * (n_rows - 1)
    assert (of_all["n_flights"] == 2).all()
    assert (worth["p_holm"] >= worth["p_value"]).all()
    scores = pd.read_csv(folder / "scores.csv")
    assert set(scores["flight"]) == {2000, 2001}
    assert np.isfinite(scores[["ods", "ois", "ap"]].to_numpy()).all()
    curve = pd.read_csv(folder / "curve.csv")
    assert set(curve["flight"]) == {2000}
    assert sorted(set(curve["n_scenes"])) == [0, 2, 4]
    assert (
        curve["ods"]
        .isna()
        .equals((curve["radiometry"] == "refused") & (curve["training_set"] != "rd"))
    )
    drawn = pd.read_csv(folder / "flights.csv")
    assert drawn["accumulation_factor"].nunique() == 2
    for name in ("flights_worth", "learning_curve"):
        assert (tmp_path / f"results/figures/{name}.svg").stat().st_size > 1000
    # A flight that lost its scores trains nothing again.
    own = yaml.safe_load((folder / "2001/config.yaml").read_text())
    assert own == flights.flight_config(own, "2001")
    trained = folder / "2001/results/tracker/rd/0.safetensors"
    before = trained.stat().st_mtime_ns
    (folder / "2001" / COUNTS).unlink()
    (folder / "worth.csv").unlink()  # else nothing asks for the counts
    run_snakemake(tmp_path, "--", "study_flights", timeout=600)
    assert trained.stat().st_mtime_ns == before
    assert (folder / "2001" / COUNTS).is_file()
