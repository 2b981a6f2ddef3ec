"""Own frames tracked by the workflow: whole segments to a job, bad frames in nobody's way."""

import formats
import pandas as pd
import pytest
import yaml
from planted_layers import SEGMENT, content_of, planted, ridge_weights, write_weights
from processes import ROOT
from runs import lines_with, parsed, run_snakemake, settings

from lib.sources import ROLES, frames_to_track, keep, kept, observed, own_frames

OTHER = "20120507_03"


def table_of(folder, names):
    """Table of frames with the role, whose layers are not known."""
    rows = [f"{name}\tData_{name}.mat\t\ttrack\n" for name in names]
    path = folder / "frames.tsv"
    path.write_text("".join([f"{formats.TABLE_HEADER}\n", *rows]))
    return path


def test_jobs_hold_whole_segments(tmp_path):
    names = [f"{SEGMENT}_00{n}" for n in (1, 2, 3)] + [f"{OTHER}_00{n}" for n in (1, 2)]
    names += ["other", "more"]  # of one segment, for all that is known
    for name in names:
        (tmp_path / f"Data_{name}.mat").touch()
    table = table_of(tmp_path, names)
    for per_job, expected in ((1, [3, 2, 2]), (4, [3, 4]), (5, [5, 2]), (100, [7])):
        jobs = frames_to_track(table, per_job)
        assert [len(job) for job in jobs] == expected
        assert [row["frame"] for job in jobs for row in job] == names


def test_frames_to_track_are_none_of_the_flight_s(tmp_path):
    table = table_of(tmp_path, ["one", "two"])
    roles = ("statistics", "train", "test")
    for name in ("one", "two", *roles):
        (tmp_path / f"Data_{name}.mat").touch()
    rows = [f"{role}\tData_{role}.mat\tData_one.mat\t{role}\n" for role in roles]
    table.write_text("".join([table.read_text(), *rows]))
    assert own_frames(table).keys() == set(roles)


def test_a_job_gets_its_frames_without_reading_the_table(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / f"Data_{SEGMENT}_001.mat").touch()
    (tmp_path / f"Data_{OTHER}_001.mat").touch()
    table = table_of(tmp_path, [f"{SEGMENT}_001", f"{OTHER}_001"])
    assert kept(table, 1, 1) is None
    jobs = frames_to_track(table, 1)
    keep(table, 1, jobs)
    monkeypatch.setattr("snowsim.io.frames.read_frames", None)
    assert [kept(table, 1, number) for number in (0, 1, 2)] == [*jobs, None]
    assert kept(table, 2, 0) is None
    # Own frames of the flight, too.
    keep(table, ROLES, [{"test": jobs[0]}])
    own = {"source": "cresis", "import": {"frames": table}}
    assert observed(own, is_job=True) == {"test": jobs[0]}
    table.write_text(table.read_text() + "\n")  # it was changed
    assert kept(table, 1, 0) is None


def test_supplements_beside_echograms_are_inputs_of_their_job(tmp_path):
    names = [f"{SEGMENT}_001", f"{SEGMENT}_002", f"{OTHER}_001"]
    for name in names:
        (tmp_path / f"Data_{name}.mat").touch()
    beside = tmp_path / f"Data_{names[1]}_supplement.nc"
    beside.touch()
    own = {"frames": str(table_of(tmp_path, names))}
    plan = parsed(tmp_path, targets=["picks"], flight={"frames_per_job": 1}, **{"import": own})
    jobs = [job for job in plan.dag.jobs if job.rule.name == "track_frames"]
    assert sorted(len(job.input.others) for job in jobs) == [0, 1]
    assert str(beside) in {file for job in jobs for file in job.input.others}


def test_tracking_has_one_output_and_the_cluster_s_profile_checks_no_contents(tmp_path):
    plan = parsed(tmp_path)
    (rule,) = [rule for rule in plan.rules if rule.name == "track_frames"]
    assert len(rule.output) == 1  # Snakemake reads all inputs once for each
    profiles = {
        name: yaml.safe_load((ROOT / f"profiles/{name}/config.yaml").read_text())
        for name in ("default", "slurm")
    }
    assert "max-checksum-file-size" in profiles["default"]
    assert "max-checksum-file-size" not in profiles["slurm"]


@pytest.mark.slow
def test_frames_are_tracked_without_annotation(tmp_path, rng):
    echogram, _ = planted(rng)
    names = [f"{SEGMENT}_007", f"{OTHER}_001"]
    good, bad = (tmp_path / f"Data_{name}.mat" for name in names)
    formats.write_mat5(good, content_of(echogram))
    bad.write_bytes(b"no echogram")
    tracker = write_weights(tmp_path, ridge_weights())
    own = {"frames": str(table_of(tmp_path, names)), "tracker": str(tracker)}
    configs = settings(tmp_path, yaml.safe_dump({"import": own}))
    done = run_snakemake(tmp_path / "run", "--", "picks", configs=configs)
    results = tmp_path / "run/results"
    table = pd.read_csv(results / "tables/tracked_frames.csv", keep_default_na=False)
    assert table["frame"].tolist() == names
    assert table["n_layers"].tolist() == [4, 0]
    assert bad.name in table["remarks"].iloc[1]
    assert lines_with(done, "warning: 1 of 2 frames could not be tracked")
    assert (tmp_path / "run/.snakemake/frames").is_dir()
    used = pd.read_csv(results / "benchmarks/track_frames/0000.tsv", sep="\t")
    assert 100 < used["max_rss"].iloc[0] < 700  # [MB], which the rule asks for beside its inputs
    assert (results / f"picks/0000/CSARP_layer/{SEGMENT}/{good.name}").is_file()
