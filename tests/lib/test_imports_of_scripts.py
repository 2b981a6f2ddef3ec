"""Rules take as inputs what their scripts import; the main path imports nothing that judges it."""

import re

import pytest

from evaluation.lib.figures.style import COLOURS
from lib.imports import PLACES, ROOT, SCRIPTS, closure, imported_files

EVALUATION = ROOT / "workflow/evaluation/scripts"
LIB = ROOT / "workflow/evaluation/lib"
FIGURES = LIB / "figures"


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
    assert not {"snowsim/io/containers.py", "snowsim/phy/render.py", "snowsim/cgan/train.py"} & files
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
    written = "".join(path.read_text() for path in (ROOT / "workflow").rglob("*.smk"))
    scripts = {*SCRIPTS.glob("*.py"), *EVALUATION.glob("*.py")}
    used = {script for script in scripts if f'"{script.name}"' in written}
    used |= {path for script in used for path in closure(script)}
    assert scripts - used == {SCRIPTS / "job.py", EVALUATION / "main_path.py"}


@pytest.mark.parametrize("folder", ["scripts", "lib", "rules"])
def test_nothing_on_the_main_path_depends_on_the_evaluation(folder):
    for path in (ROOT / "workflow" / folder).iterdir():
        if path.suffix == ".py":
            needed = [path, *closure(path)]
            assert not [file for file in needed if "evaluation" in file.relative_to(ROOT).parts]
        elif path.suffix == ".smk":
            assert "evaluation/" not in path.read_text(), path


def test_what_draws_another_stage_s_figures_is_no_code_of_a_stage():
    code = {path.stem for path in closure(EVALUATION / "plot_tracker.py")}
    stages = {path.stem for path in FIGURES.glob("*.py")} - {"style", "tracker", "__init__"}
    assert {"tracker", "style", "files"} <= code
    assert not code & stages


def test_colours_stand_in_the_style_alone():
    assert all(re.fullmatch("#[0-9A-F]{6}", colour) for colour in COLOURS.values())
    for path in [*LIB.glob("figures/*.py"), *LIB.glob("report/*.py")]:
        if path.stem != "style":
            assert not re.findall(
                r'"#[0-9A-Fa-f]{6}"|color="(?:black|white)"|RD\+', path.read_text()
            ), path
