"""Snakemake does not follow imports: what rules declare as their code is what their scripts import."""

import ast
import re
from pathlib import Path

from sources import ROOT, closure

SCRIPTS = sorted((ROOT / "workflow/scripts").glob("*.py"))


# Every rule lists these: they are what the stages have in common.
CORE = {"__init__", "constants", "echogram", "seeding"}


def stage_of(path):
    """First folder or module below the package."""
    return path.with_suffix("").parts[1]


SHARED_BY_ALL = {"job"}


def imported_scripts(script):
    """Other scripts that a script imports, and those that they import, but for what all of them share."""
    found, waiting = set(), [script]
    while waiting:
        for node in ast.walk(ast.parse(waiting.pop().read_text())):
            name = node.module if isinstance(node, ast.ImportFrom) else None
            path = ROOT / f"workflow/scripts/{name}.py"
            if name not in SHARED_BY_ALL and path in SCRIPTS and path not in found:
                found.add(path)
                waiting.append(path)
    return found


def imported(script):
    """Files that the result of a script depends on, relative to the repository."""
    scripts = imported_scripts(script)
    modules = {path for each in (script, *scripts) for path in closure(each)}
    return {path.relative_to(ROOT) for path in modules | scripts}


def rules_as_written(path):
    """Name, script and declared files of the rules of one file, read from its text."""
    for name, text in re.findall(r"^rule (\w+):\n(.*?)(?=^rule |\Z)", path.read_text(), flags=re.MULTILINE | re.DOTALL):
        script = re.search(r'"\.\./scripts/(\w+\.py)"', text)
        if script:
            parts = re.findall(r'"([\w.]+)"', re.search(r"package\((.*?)\)", text, flags=re.DOTALL)[1])
            yield name, ROOT / "workflow/scripts" / script[1], {file for part in parts for file in files_of(part)}


def files_of(part):
    path = ROOT / "snowsim" / part.replace(".", "/")
    files = path.rglob("*.py") if path.is_dir() else [path.with_suffix(".py")]
    return {file.relative_to(ROOT) for file in files}


def test_closure_follows_imports_of_imports_and_spares_what_is_not_called():
    # By hand: the script imports io.files and statistics, whose modules import each other and one module of phy;
    # no reader of a file format is imported, although the package io can read them all.
    files = {str(path) for path in imported(ROOT / "workflow/scripts/summarise_frames.py")}
    assert {"snowsim/io/files.py", "snowsim/statistics/frames.py", "snowsim/phy/waveform.py"} <= files
    assert not {"snowsim/io/mat5.py", "snowsim/phy/render.py", "snowsim/cgan/train.py"} & files


def test_every_rule_declares_every_module_its_script_imports(rules):
    missing = {
        rule.name: sorted(map(str, imported(rule.script) - rule.code))
        for rule in rules
        if rule.script and not imported(rule.script) <= rule.code
    }
    assert missing == {}


def test_no_rule_declares_a_stage_its_script_does_not_import(rules):
    for rule in rules:
        stages = {stage_of(path) for path in rule.code} - CORE
        idle = stages - {stage_of(path) for path in imported(rule.script)} if rule.script else set()
        assert not idle, f"{rule.name} would rerun after an edit of {idle}, which {rule.script.name} does not import"


def test_rules_of_other_sources_declare_what_their_scripts_import():
    core = {Path(f"snowsim/{name}.py") for name in CORE}
    for path in sorted((ROOT / "workflow/rules").glob("import_*.smk")):
        for name, script, code in rules_as_written(path):
            assert imported(script) <= code | core, f"{name} of {path.name}"


def test_every_script_is_used_by_a_rule_or_by_another_script():
    written = "".join(path.read_text() for path in (ROOT / "workflow/rules").glob("*.smk"))
    used = {script for script in SCRIPTS if f"/scripts/{script.name}" in written}
    used |= {other for script in used for other in imported_scripts(script)}
    assert set(SCRIPTS) - used == {ROOT / f"workflow/scripts/{name}.py" for name in SHARED_BY_ALL}


def test_scripts_see_settings_through_params_alone():
    # Then a setting that alters a result is a parameter of its rule, and Snakemake reruns it.
    for script in SCRIPTS:
        read = {
            node.attr
            for node in ast.walk(ast.parse(script.read_text()))
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "snakemake"
        }
        assert read <= {"input", "output", "params", "wildcards", "log", "rule", "resources"}, f"{script.name}: {read}"
