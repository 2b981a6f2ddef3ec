"""The same configuration gives the same bytes, however the work is divided and ordered."""

import pytest
import reproducible
from runs import run_snakemake, settings


def test_one_core_gives_the_same_bytes_as_two(tiny_run, reproducible_targets, tmp_path):
    run_snakemake(tmp_path, "--", *reproducible_targets, cores=1, timeout=3600)
    assert reproducible.digests(tmp_path / "results") == reproducible.digests(tiny_run / "results")


@pytest.mark.slow
def test_other_shards_in_another_order_give_the_same_tables_and_figures(tiny_run, reproducible_targets, tmp_path):
    configs = settings(tmp_path, "flight: {frames_per_job: 1}\nlabels: {shard_size: 5}\nbenchmark: {shard_size: 4}")
    # What does not hold shards, and no network, whose file names the shards it was trained on.
    wanted = [name for name in reproducible_targets if name.startswith(("results/tables/", "results/figures/"))]
    wanted.append("results/statistics.nc")
    # What comes last by itself is wanted first.
    first = [name for name in wanted if "closed_loop" in name or "realism" in name]
    assert first
    folder = tmp_path / "run"
    run_snakemake(folder, "--prioritize", *first, "--", *wanted, cores=2, configs=configs, timeout=3600)
    assert len(list((folder / "results/labels").glob("*.nc"))) == 2
    assert len(list((folder / "results/statistics").glob("*.nc"))) == 3
    expected, found = (reproducible.digests(run / "results") for run in (tiny_run, folder))
    names = [name.removeprefix("results/") for name in wanted]
    assert {name: found[name] for name in names} == {name: expected[name] for name in names}
