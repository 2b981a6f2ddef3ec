"""The page add-your-own: a renderer and a tracker enter the workflow by one file."""

import pandas as pd
import pytest
from pages import save_named
from runs import ROOT, TINY, parsed, refused, run_snakemake

from snowsim.io import SceneSet, read_model

PAGE = ROOT / "docs/start/add-your-own.md"


@pytest.fixture
def with_files(tmp_path):
    """Folder with the files of the page."""
    assert save_named(PAGE, tmp_path) == ["boxes.py", "rises.py", "mine.yaml"]
    return tmp_path


@pytest.mark.slow
def test_the_page_followed_gives_its_columns_tables_and_a_report(with_files):
    run_snakemake(with_files, configs=(*TINY, with_files / "mine.yaml"), timeout=900)
    results = with_files / "results"
    assert {"cgan", "phy", "boxes"} <= set(pd.read_csv(results / "tables/table2.csv"))
    assert "rd_boxes_ods" in pd.read_csv(results / "tables/table3.csv")
    scored = pd.read_csv(results / "tables/own_rises.csv").set_index("image")
    test = SceneSet(sorted((results / "benchmark/test").glob("*.nc")))
    assert {scene.name for scene in test} < set(scored.index)
    assert scored.loc["all", "ods"] > 0.2
    drawn = SceneSet(sorted((results / "labels").glob("*.nc")))
    rendered = SceneSet(sorted((results / "own/boxes/labels").glob("*.nc")))
    assert [scene.name for scene in rendered] == [scene.name for scene in drawn]
    assert "boxes" in (results / "report.html").read_text()
    # What a tracker was trained on is part of what it may be resumed from.
    names = ("rd", "rd_boxes")
    made_of = [read_model(results / f"tracker/{name}/0.safetensors")[1] for name in names]
    assert made_of[0]["data"] != made_of[1]["data"]
    # As printed there is neither, and an edit runs what depends on it.
    again = (with_files, "--dry-run", "all", "as_printed")
    (with_files / "boxes.py").write_text((with_files / "boxes.py").read_text() + "# edited\n")
    planned = run_snakemake(*again, configs=(*TINY, with_files / "mine.yaml")).stdout
    assert "render_own" in planned
    assert "printed_render_own" not in planned


@pytest.mark.parametrize("targets", [["all"], ["as_printed"], ["study_flights", "study_budgets"]])
def test_no_target_is_ambiguous_with_functions_of_ones_own(with_files, targets):
    for name in ("lines.py", "noise.py"):
        (with_files / name).touch()
    own = {
        "renderers": {"lines": "lines.py", "noise": "noise.py"},
        "trackers": {"lines": "lines.py"},
    }
    rules = [job.rule.name for job in parsed(with_files, targets=targets, own=own).dag.jobs]
    assert ("render_own" in rules) == (targets == ["all"])


def test_a_name_that_results_have_already_is_refused(tmp_path):
    for name in ("phy", "gd", "own", "equal", "my_boxes", "Boxes"):
        assert "expected: small letters" in refused(tmp_path, own={"renderers": {name: "a.py"}})
    assert "expected: a Python file" in refused(tmp_path, own={"trackers": {"a": "a.m"}})
