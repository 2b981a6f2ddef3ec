"""The same configuration gives the same bytes, however the work is divided and ordered."""

import shutil

import pytest
import reproducible
from runs import run_snakemake, settings


def assert_same_bytes(run, tiny_run, names):
    found = reproducible.digests(run / "results")
    expected = reproducible.digests(tiny_run / "results")
    for name in names:
        assert found[name] == expected[name], name


def test_what_one_core_makes_again_has_the_bytes_of_two(tiny_run, tmp_path):
    # Labels, both renders of them, both networks; the flight is not made again, nor all that
    # follows it.
    names = ["labels/0000.nc", "phy/labels/0000.nc", "cgan/labels/0000.nc"]
    names += ["cgan/generator.safetensors", "tracker/rd/0.safetensors"]
    targets = [f"results/{name}" for name in names]
    folder = shutil.copytree(tiny_run, tmp_path / "run")
    for target in targets:
        (folder / target).unlink()
    run_snakemake(folder, "--rerun-triggers", "mtime", "--", *targets, cores=1)
    assert_same_bytes(folder, tiny_run, names)


@pytest.mark.slow
def test_other_shards_in_another_order_give_the_same_tables_and_figures(
    tiny_run, reproducible_targets, tmp_path
):
    shards = "flight: {frames_per_job: 1}\nlabels: {shard_size: 5}\nbenchmark: {shard_size: 4}"
    configs = settings(tmp_path, shards)
    # What does not hold shards, and no network, whose file names the shards it was trained on.
    wanted = [
        name
        for name in reproducible_targets
        if name.startswith(("results/tables/", "results/figures/"))
    ]
    wanted.append("results/statistics.nc")
    # What comes last by itself is wanted first.
    first = [name for name in wanted if "closed_loop" in name]
    assert first
    folder = tmp_path / "run"
    run_snakemake(folder, "--prioritize", *first, "--", *wanted, configs=configs, timeout=3600)
    assert len(list((folder / "results/labels").glob("*.nc"))) == 2
    assert len(list((folder / "results/statistics").glob("*.nc"))) == 4
    assert_same_bytes(folder, tiny_run, [name.removeprefix("results/") for name in wanted])
