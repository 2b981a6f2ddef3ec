"""Rules take as inputs what their scripts import, figures what their list names."""

import importlib
import inspect
import re
from pathlib import Path

import pytest
import yaml

from evaluation.lib.figures.style import COLOURS
from lib.imports import PLACES, ROOT, SCRIPTS, closure, imported_files
from lib.registry import drawn_by, inputs_of, plots, settings_of


def names(script):
    return {str(path.relative_to(ROOT)) for path in closure(SCRIPTS / script)}


def test_closure_follows_imports_of_imports_inside_functions_too_and_spares_what_is_not_called():
    # By hand: the script imports io.files and statistics, whose modules import each other and one
    # module of phy; no reader of a file format is imported, although the package io can read them
    # all.
    files = names("summarise_frames.py")
    assert {
        "snowsim/io/files.py",
        "snowsim/statistics/summaries.py",
        "snowsim/phy/waveform.py",
    } <= files
    assert not {"snowsim/io/matlab.py", "snowsim/phy/render.py", "snowsim/cgan/train.py"} & files
    # The names of the reference flight are imported when first asked for.
    assert "snowsim/reference/echo.py" in names("reference_frames.py")
    assert "workflow/scripts/job.py" not in names("reference_frames.py")


def test_an_import_that_is_added_is_seen(tmp_path, monkeypatch):
    for place in ("snowsim", "lib"):
        monkeypatch.setitem(PLACES, place, tmp_path)
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib/b.py").write_text("")
    (tmp_path / "lib/a.py").write_text("def f():\n    from lib.b import g\n")
    script = tmp_path / "script.py"
    script.write_text("from lib.a import f\n")
    assert closure(script) == [tmp_path / "lib/a.py", tmp_path / "lib/b.py"]
    assert imported_files(script) == [tmp_path / "lib/a.py"]


def test_every_script_is_used_by_a_rule_or_by_another_script():
    written = "".join(path.read_text() for path in (ROOT / "workflow/rules").glob("*.smk"))
    used = {script for script in SCRIPTS.glob("*.py") if f"/scripts/{script.name}" in written}
    used |= {path for script in used for path in closure(script)}
    assert set(SCRIPTS.glob("*.py")) - used == {SCRIPTS / "job.py"}


FIGURES = yaml.safe_load((ROOT / "workflow/figures.yaml").read_text())
LIB = ROOT / "workflow/lib"


@pytest.mark.parametrize("stage", FIGURES)
def test_every_figure_is_drawn_by_the_function_of_its_name_from_what_the_list_names(stage):
    module = importlib.import_module(f"evaluation.lib.figures.{stage}")
    for file, figure in FIGURES[stage].items():
        inputs = (figure.get(kind, ()) for kind in ("tables", "inputs", "scenes"))
        named = set().union(*inputs, settings_of({0: figure}))
        taken = set(inspect.signature(getattr(module, Path(file).stem)).parameters)
        assert taken - {"source", "studies"} == named, file
        assert ("studies" in taken) == ("studies" in figure), file
        assert figure["caption"].endswith("."), file
        assert len(figure["caption"].split()) > 3, file


def test_what_a_source_cannot_give_is_left_to_a_rule_of_its_own():
    found = plots(
        {"a": {"x.svg": {}, "y.svg": {"needs": "a map"}}}, {"a map": "images hold no positions"}
    )
    assert {rule: list(figures) for rule, figures in found.items()} == {
        ("plot_a", "a"): ["x.svg"],
        ("plot_a_left_out", "a"): ["y.svg"],
    }


def test_paths_are_expanded_and_a_name_has_one_path_in_a_stage():
    frames = {"frame": lambda path: [path.replace("{frame}", "7")]}
    figures = {"x": {"tables": ["t"]}, "y": {"tables": ["t"], "inputs": {"f": "flight/{frame}.nc"}}}
    assert inputs_of(figures, frames) == {"t": "results/tables/t.csv", "f": ["results/flight/7.nc"]}
    with pytest.raises(
        ValueError, match=r"t: expected one path in a stage, got tables/t\.csv and t\.nc"
    ):
        inputs_of({**figures, "z": {"inputs": {"t": "t.nc"}}}, frames)


def test_figures_of_another_stage_are_no_code_of_a_stage():
    code = {Path(file).stem for file in drawn_by("tracker")(None)}
    assert {"tracker", "style", "files"} <= code
    assert not code & (set(FIGURES) - {"tracker"})


def test_colours_stand_in_the_style_alone():
    assert all(re.fullmatch("#[0-9A-F]{6}", colour) for colour in COLOURS.values())
    for path in [*LIB.glob("figures/*.py"), *LIB.glob("report/*.py")]:
        if path.stem != "style":
            assert not re.findall(
                r'"#[0-9A-Fa-f]{6}"|color="(?:black|white)"|RD\+', path.read_text()
            ), path
