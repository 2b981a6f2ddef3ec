"""The benchmark of two commits: what it calls slower, and that every task runs."""

import importlib.util

import pytest
from processes import ROOT

SCRIPT = importlib.util.spec_from_file_location("commits", ROOT / "benchmarks/compare_commits.py")
commits = importlib.util.module_from_spec(SCRIPT)
SCRIPT.loader.exec_module(commits)


def test_a_task_is_slower_if_it_is_in_every_round():
    rounds = [
        ({"a": 1.0, "b": 1.0, "c": 1.0, "d": None}, {"a": 2.0, "b": 2.0, "c": 0.5, "d": 1.0}),
        ({"a": 1.1, "b": 1.0, "c": 1.2, "d": None}, {"a": 1.5, "b": 1.0, "c": 0.5, "d": 1.0}),
    ]
    table = commits.compared(rounds, slower=1.2).set_index("task")
    assert table["verdict"].tolist() == ["slower", "same", "faster", "not run"]
    assert table.loc["a", ["base_ms", "other_ms", "ratio"]].tolist() == [1000, 1500, 1.5]


@pytest.mark.slow
def test_every_task_runs_in_this_checkout():
    assert all(seconds > 0 for seconds in commits.time_commit(ROOT).values())
