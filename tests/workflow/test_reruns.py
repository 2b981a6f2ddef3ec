"""Edits rerun what depends on them and nothing else."""

import os
import subprocess
from collections import defaultdict
from contextlib import contextmanager
from functools import partial

import pytest
from runs import ROOT, parsed, rules_planned, rules_to_run, run_snakemake, settings, text_of


@contextmanager
def edited(path):
    """A line more in a file of the copied source, undone at the end, the file's time with it."""
    text = path.read_text()
    times = path.stat()
    path.write_text(text + "\n# edited\n")
    try:
        yield
    finally:
        path.write_text(text)
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


@pytest.fixture(scope="module")
def plan(tiny_run, tiny_source):
    """Function that runs Snakemake in the folder of the finished run, from its source."""
    return partial(run_snakemake, tiny_run, source=tiny_source)


@pytest.fixture(scope="module")
def downstream(tmp_path_factory):
    """For each rule of a whole run: itself and all rules that use what it makes."""
    dag = parsed(tmp_path_factory.mktemp("whole"), targets=["all"]).dag
    found = defaultdict(set)
    for job in dag.jobs:
        using = {each.rule.name for each in dag.bfs(dag.depending, job)}
        found[job.rule.name] |= using - {"all"}
    return found


def test_an_edited_script_reruns_its_rule_and_what_depends_on_it(plan, tiny_source, downstream):
    # By a process of its own: a process that plans remembers the times of scripts.
    with edited(tiny_source / "workflow/scripts/render_phy.py"):
        assert rules_to_run(plan("--dry-run")) == downstream["render_phy"]


def test_edited_code_of_the_package_is_warned_of_and_a_rule_is_rerun_by_force(
    plan, tiny_source, downstream
):
    with edited(tiny_source / "snowsim/phy/waveform.py"):
        planned = plan("--dry-run")
        assert "snowsim/phy/waveform.py is newer than results/statistics.nc" in text_of(planned)
        assert "Nothing to be done" in text_of(planned)
        forced = plan("--dry-run", "--forcerun", "render_phy")
        assert rules_to_run(forced) == downstream["render_phy"]


def test_touching_unchanged_inputs_reruns_nothing(plan, tiny_run, tiny_source):
    inputs = [
        tiny_source / "snowsim/data/universal.onnx",
        *(tiny_run / "results/flight").glob("*.nc"),
        *(tiny_run / "results/labels").glob("*.nc"),
        *(tiny_run / "results/phy").rglob("*.nc"),
        tiny_run / "results/statistics.nc",
    ]
    # Snakemake compares contents below a size only, 1 MB by default; the files of a run are larger.
    assert max(path.stat().st_size for path in inputs) > 1e6
    for path in inputs:
        path.touch()
    planned = plan("--dry-run")
    assert "Nothing to be done" in text_of(planned)
    assert "is newer than" not in text_of(planned)


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("similarity: {window_rows: 20}", {"tabulate_similarity"}),
        ("phy: {n_looks: 20}", {"render_phy"}),
        ("tracker: {training: {learning_rate: 5.0e-4}}", {"train_tracker"}),
        (
            "reference: {picks: {picker_db: 1.4}}",
            {"reference_frames_0000", "reference_frames_0001", "reference_scenes"},
        ),
    ],
)
def test_a_setting_reruns_what_depends_on_it_and_nothing_else(
    tiny_run, tiny_source, tmp_path, downstream, text, first
):
    planned, triggered = rules_planned(tiny_run, settings(tmp_path, text), source=tiny_source)
    assert first <= triggered
    assert planned == set().union(*(downstream[name] for name in triggered))


def test_a_finished_run_that_is_copied_with_its_source_plans_nothing(
    tiny_run, tiny_source, tmp_path
):
    for name, folder in (("elsewhere", tiny_source), ("run", tiny_run)):
        subprocess.run(["cp", "-a", folder, tmp_path / name], check=True)
    planned = run_snakemake(tmp_path / "run", "--dry-run", source=tmp_path / "elsewhere")
    assert "Nothing to be done" in text_of(planned)


@pytest.mark.parametrize("targets", [["all", "as_printed", "pretrained"], ["study_flights"]])
def test_no_rule_has_a_path_of_the_checkout_among_its_inputs(tmp_path, targets):
    for job in parsed(tmp_path, targets=targets).dag.jobs:
        assert not [path for path in job.input if path.startswith(str(ROOT))], job.rule.name
