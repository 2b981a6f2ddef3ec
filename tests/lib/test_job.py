"""A script is handed what its rule names; its log ends with the error; bad input is one line."""

import ast
import os
from types import SimpleNamespace

import pytest
from job import available_memory_mb, job, named
from snakemake.iocontainers import Namedlist

from lib.imports import ROOT

SHARED = {"job", "main_path"}  # by scripts


def some_job(folder, mem_mb=0):
    return SimpleNamespace(
        rule="some_rule", log=folder / "logs/some.log", resources={"mem_mb": mem_mb}
    )


def items(*unnamed, **of_names):
    """Inputs, outputs or params as Snakemake hands them over: files of a name are a list."""
    given = Namedlist(list(unnamed))
    for name, value in of_names.items():
        start = len(given)
        if isinstance(value, list):
            given.extend(value)
            given._set_name(name, start, end=len(given))
        else:
            given.append(value)
            given._set_name(name, start)
    return given


def test_inputs_outputs_and_params_are_handed_over_by_their_names():
    snakemake = SimpleNamespace(
        input=items(
            scenes=["a.nc", "b.nc"],
            none=[],
            statistics="s.nc",
            code=["a.py", "b.py"],
            unread="c.csv",
        ),
        output=items(table="t.csv"),
        params=Namedlist(fromdict={"seed": 1, "span": [0, 2]}),
    )
    assert named(snakemake) == {
        "scenes": ["a.nc", "b.nc"],
        "none": [],
        "statistics": "s.nc",
        "table": "t.csv",
        "seed": 1,
        "span": [0, 2],
    }


@pytest.mark.parametrize(
    ("output", "message"),
    [
        (items("a.csv"), "output: expected a name for every item, found 1 of 1 without"),
        (
            items("a.csv", table="b.csv"),
            "output: expected a name for every item, found 1 of 2 without",
        ),
        (
            items(scenes="b.nc"),
            "expected each name once in input, output and params, found scenes twice",
        ),
    ],
    ids=["unnamed", "one unnamed", "twice"],
)
def test_an_item_without_a_name_of_its_own_is_refused_in_one_line(output, message):
    with pytest.raises(ValueError, match="expected ") as error:
        named(SimpleNamespace(input=items(scenes="a.nc"), output=output, params=items()))
    assert str(error.value) == message


@pytest.mark.parametrize(
    "script",
    [path for path in sorted((ROOT / "workflow").rglob("scripts/*.py")) if path.stem not in SHARED],
    ids=lambda path: path.stem,
)
def test_a_script_is_functions_and_the_run_of_one_of_them(script):
    # Importing it then does nothing, and it sees Snakemake through the names of its rule alone.
    tree = ast.parse(script.read_text())
    *body, last = tree.body
    own = {node.name for node in body if isinstance(node, ast.FunctionDef)}
    assert isinstance(last, ast.Expr)
    assert ast.unparse(last) in {f"run({name})" for name in own}
    assert "snakemake" not in {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}


@pytest.mark.skipif(
    available_memory_mb() is None, reason="this system does not say how much memory is available"
)
def test_a_job_that_needs_more_memory_than_there_is_does_not_start(tmp_path, capsys):
    installed_mb = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**20
    assert 0 < available_memory_mb() < installed_mb
    with pytest.raises(SystemExit), job(some_job(tmp_path, mem_mb=10**9)):
        pytest.fail("the job started")
    printed = capsys.readouterr().err
    refusal = "error: some_rule: memory: expected at least 1000000000 MB available, got "
    assert printed.startswith(refusal)


@pytest.mark.parametrize("error", [ValueError, OSError, ZeroDivisionError])
def test_a_log_ends_with_the_error(tmp_path, error):
    reason = "a.nc: expected this, got that"
    with pytest.raises((SystemExit, error)), job(some_job(tmp_path)):
        raise error(reason)
    log = (tmp_path / "logs/some.log").read_text().strip()
    assert "Traceback" in log
    assert log.splitlines()[-1].endswith(reason)
