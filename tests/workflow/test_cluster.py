"""The workflow through SLURM: a cluster of one node is started for it."""

import subprocess

import formats
import pytest
import reproducible
import yaml
from planted_layers import SEGMENT, content_of, planted, ridge_weights, write_weights
from runs import (
    command,
    environment,
    parsed,
    run_snakemake,
    settings,
    source_tree,
    text_of,
    wait_until,
)
from slurm import missing_programs, one_node_cluster, scripts_at_work

OTHER = "20120507_03"
SOON = ("--latency-wait", 10, "--slurm-init-seconds-before-status-checks", 5)


@pytest.fixture(scope="module")
def slurm_plugin():
    pytest.importorskip(
        "snakemake_executor_plugin_slurm", reason="Snakemake's executor plugin for SLURM is missing"
    )


@pytest.fixture(scope="module")
def cluster(slurm_plugin, tmp_path_factory):
    """Folder of the client programs of a running one-node cluster."""
    missing = missing_programs()
    if missing:
        pytest.skip(f"SLURM is not installed (make test-machine): {', '.join(missing)}")
    with one_node_cluster(tmp_path_factory.mktemp("slurm") / "cluster") as programs:
        yield programs


@pytest.mark.cluster
def test_slurm_gives_the_bytes_of_a_local_run(cluster, tiny_run, reproducible_targets, tmp_path):
    # A node of two cores: a group must not ask for more.
    words = ("--jobs", 8, *SOON, "--", *reproducible_targets)
    env = environment(PATH=f"{cluster}:{environment()['PATH']}")
    done = run_snakemake(tmp_path / "run", *words, profile="slurm", timeout=3000, env=env)
    assert "SLURM jobid" in text_of(done)
    assert reproducible.digests(tmp_path / "run/results") == reproducible.digests(
        tiny_run / "results"
    )


@pytest.mark.cluster
def test_frames_of_a_killed_job_are_tracked_as_if_nothing_had_happened(cluster, tmp_path, rng):
    rows = ["frame\techogram\tlayers\trole\n"]
    for segment in (SEGMENT, OTHER):
        path = tmp_path / f"Data_{segment}_001.mat"
        formats.write_mat5(path, content_of(planted(rng)[0]))
        rows.append(f"{segment}_001\t{path}\t\ttrack\n")
    (tmp_path / "frames.tsv").write_text("".join(rows))
    tracker = write_weights(tmp_path, ridge_weights())
    own = {"frames": str(tmp_path / "frames.tsv"), "tracker": str(tracker)}
    configs = settings(tmp_path, yaml.safe_dump({"import": own, "flight": {"frames_per_job": 1}}))
    undisturbed = run_snakemake(tmp_path / "undisturbed", "--", "picks", configs=configs)
    assert "2 of 4 steps" in text_of(undisturbed)  # a job for each segment, then the table
    words = command(tmp_path / "run", *SOON, "--", "picks", configs=configs, profile="slurm")
    env = environment(PATH=f"{cluster}:{environment()['PATH']}")
    with subprocess.Popen(
        words, env=env, cwd=source_tree(), stderr=subprocess.PIPE, text=True
    ) as run:
        assert wait_until(lambda: any(scripts_at_work("track_frames.py")), seconds=120)
        next(scripts_at_work("track_frames.py")).kill()
        said = run.communicate(timeout=500)[1]
    assert run.returncode == 0, said[-4000:]
    assert "Trying to restart job" in said
    found, expected = (
        reproducible.digests(tmp_path / name / "results/picks") for name in ("run", "undisturbed")
    )
    assert len(found) >= 6
    assert found == expected


def test_the_slurm_profile_plans_the_whole_run(slurm_plugin, tmp_path):
    run_snakemake(tmp_path, "--dry-run", profile="slurm")


@pytest.mark.parametrize("device", ["cpu", "cuda"])
def test_rules_that_use_a_gpu_ask_for_one(tmp_path, device):
    plan = parsed(tmp_path, cgan={"device": device}, tracker={"device": device})
    rules = list(plan.rules)
    n_gpus = {rule.name: dict(rule.resources.items()).get("gpu") for rule in rules}
    asking = {name for name, resource in n_gpus.items() if resource is not None and resource.value}
    # Exactly the rules that are given a device.
    with_device = {rule.name for rule in rules if "device" in dict(rule.params.items())}
    assert with_device >= {"train_cgan", "train_tracker"}
    assert asking == (with_device if device == "cuda" else set())
