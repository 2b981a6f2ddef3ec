"""Snakemake does not follow imports: rules take as inputs what their scripts import, as computed here."""

from lib.imports import PLACES, ROOT, SCRIPTS, closure, imported_files


def names(script):
    return {str(path.relative_to(ROOT)) for path in closure(SCRIPTS / script)}


def test_closure_follows_imports_of_imports_and_spares_what_is_not_called():
    # By hand: the script imports io.files and statistics, whose modules import each other and one module of phy;
    # no reader of a file format is imported, although the package io can read them all.
    files = names("summarise_frames.py")
    assert {"snowsim/io/files.py", "snowsim/statistics/summaries.py", "snowsim/phy/waveform.py"} <= files
    assert not {"snowsim/io/matlab.py", "snowsim/phy/render.py", "snowsim/cgan/train.py"} & files


def test_closure_sees_imports_inside_functions_and_other_scripts():
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
