"""The workflow through SLURM: a cluster of one node is started for it."""

import pytest
import reproducible
from runs import environment, parsed, run_snakemake, text_of
from slurm import missing_programs, one_node_cluster


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
    words = (
        "--jobs",
        8,
        "--latency-wait",
        10,
        "--slurm-init-seconds-before-status-checks",
        5,
    )
    env = environment(PATH=f"{cluster}:{environment()['PATH']}")
    words += ("--", *reproducible_targets)
    done = run_snakemake(tmp_path / "run", *words, profile="slurm", timeout=3000, env=env)
    assert "SLURM jobid" in text_of(done)
    assert reproducible.digests(tmp_path / "run/results") == reproducible.digests(
        tiny_run / "results"
    )


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
