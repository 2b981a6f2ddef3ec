"""Snakemake does not follow imports: what rules declare as their code is what their scripts import."""

import ast

from sources import ROOT, closure

SCRIPTS = sorted((ROOT / "workflow/scripts").glob("*.py"))


# Every rule lists these: they are what the stages have in common.
CORE = {"__init__", "constants", "echogram", "seeding"}


def stage_of(path):
    """First folder or module below the package."""
    return path.with_suffix("").parts[1]


def imported(script):
    return {path.relative_to(ROOT) for path in closure(script)}


def test_closure_follows_imports_of_imports_and_spares_what_is_not_called():
    # By hand: the script imports io.files and statistics, whose modules import each other and one module of phy;
    # no reader of a file format is imported, although the package io can read them all.
    files = {str(path) for path in imported(ROOT / "workflow/scripts/summarise_frame.py")}
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


def test_scripts_are_named_as_rules_and_used(rules):
    used = {rule.script for rule in rules if rule.script}
    assert {script for script in SCRIPTS if script.name != "job.py"} == used


def test_scripts_share_nothing_but_what_all_have(rules):
    names = {script.stem for script in SCRIPTS} - {"job"}
    for script in SCRIPTS:
        for node in ast.walk(ast.parse(script.read_text())):
            modules = (
                [node.module]
                if isinstance(node, ast.ImportFrom)
                else [alias.name for alias in node.names]
                if isinstance(node, ast.Import)
                else []
            )
            assert not names & set(modules), f"{script.name} imports another script: put what they share in snowsim"


def test_scripts_see_settings_through_params_alone():
    # Then a setting that alters a result is a parameter of its rule, and Snakemake reruns it.
    for script in SCRIPTS:
        read = {
            node.attr
            for node in ast.walk(ast.parse(script.read_text()))
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "snakemake"
        }
        assert read <= {"input", "output", "params", "wildcards", "log", "rule", "resources"}, f"{script.name}: {read}"
