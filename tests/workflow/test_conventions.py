"""What people expect of a workflow: named targets, a clean lint, use from another workflow."""

import re
import shutil
from pathlib import Path

import pytest
import yaml
from runs import ROOT, SNAKEMAKE, call, parsed, run_snakemake, source_tree, text_of

from lib.imports import closure

TARGETS = {
    "all",
    "flight",
    "labels",
    "renders",
    "similarity",
    "trackers",
    "export",
    "report",
    "studies",
}
SNAKEFILES = ("Snakefile", "workflow/Snakefile")


def test_rules_are_formatted_and_lint_finds_nothing(tmp_path):
    done = call(SNAKEMAKE, "--lint", "--directory", tmp_path)
    assert done.returncode == 0, text_of(done)
    assert "Congratulations, your workflow is in a good condition" in text_of(done)
    pytest.importorskip("snakefmt")
    done = call(SNAKEMAKE.with_name("snakefmt"), "--check", "Snakefile", "workflow", cwd=ROOT)
    assert done.returncode == 0, text_of(done)


def test_rules_with_a_script_take_its_imports_as_code_log_measure_and_say_what_they_do(rules):
    for rule in rules:
        if rule.script:
            imported = {path.relative_to(ROOT) for path in closure(rule.script)}
            assert imported <= rule.code, rule.name
            assert len(rule.declared.log) == 1, rule.name
            assert rule.declared.benchmark, rule.name
            assert rule.declared.conda_env, rule.name
            assert rule.declared.message, rule.name


def test_every_target_is_named_and_described_by_help_in_its_group(rules, tmp_path):
    done = run_snakemake(tmp_path, "--", "help")
    groups = re.findall(
        r"^(main|pretrained|evaluation|studies): .*\n((?:  \w.*\n)*)",
        text_of(done),
        flags=re.MULTILINE,
    )
    assert [name for name, _ in groups] == ["main", "pretrained", "evaluation", "studies"]
    listed = {}
    for group, lines in groups:
        in_group = dict(re.findall(r"^  (\w+) {2,}(\S.*)$", lines, flags=re.MULTILINE))
        files = {Path(rule.declared.snakefile) for rule in rules if rule.name in in_group}
        apart = {file.is_relative_to(ROOT / "workflow/evaluation") for file in files}
        assert apart == {group in ("evaluation", "studies")}
        listed |= in_group
    assert set(listed) >= TARGETS
    assert set(listed) == {rule.name for rule in rules if not rule.declared.output} - {"help"}
    # A name alone, or Python's None, describes nothing.
    assert all(len(text.split()) > 2 for text in listed.values()), listed


def test_targets_run_where_snakemake_runs(rules):
    # On a cluster a target that only collects files is no job of its own.
    for rule in rules:
        if not rule.declared.output:
            assert rule.declared.workflow.is_local(rule.declared), f"{rule.name} is no local rule"


def test_targets_can_be_planned_by_name(tmp_path):
    parsed(tmp_path, targets=TARGETS)


def test_studies_collects_every_study(rules):
    (all_studies,) = [rule.declared for rule in rules if rule.name == "studies"]
    collected = {str(file) for file in all_studies.input[0](None)}
    studies = [
        rule for rule in rules if rule.name.startswith("study_") and not rule.declared.output
    ]
    assert len(studies) >= 3
    assert collected == {str(file) for rule in studies for file in rule.declared.input}


def test_the_catalogue_knows_how_to_run_the_workflow():
    catalogue = yaml.safe_load((ROOT / ".snakemake-workflow-catalog.yml").read_text())
    usage = catalogue["usage"]
    deployment = usage["software-stack-deployment"]
    assert deployment["conda"] is True
    assert usage["report"] is deployment["report"] is True
    assert (ROOT / "config/README.md").is_file()


def test_both_snakefiles_plan_the_same_jobs(tmp_path):
    # How many jobs of each rule, and every file that they make or are made anew for.
    def plan(snakefile):
        text = run_snakemake(tmp_path, "--dry-run", snakefile=snakefile).stdout
        return sorted(re.findall(r"^\w+ +\d+$|\bresults/[\w./]+", text, flags=re.MULTILINE))

    ours, theirs = map(plan, SNAKEFILES)
    assert len(ours) > 100
    assert ours == theirs


def test_no_two_rules_write_one_file(rules):
    writers = {}
    for rule in rules:
        for output in rule.declared.output:
            writers.setdefault(str(output), []).append(rule.name)
    assert len(writers) > 100
    assert [names for names in writers.values() if len(names) > 1] == []


@pytest.mark.parametrize("snakefile", SNAKEFILES)
def test_another_workflow_can_use_this_one_as_a_module(tmp_path, snakefile):
    shutil.copy2(ROOT / "config/config.yaml", tmp_path / "config.yaml")
    (tmp_path / "Snakefile").write_text(f"""\
configfile: "config.yaml"
module snowsim:
    snakefile: "{source_tree()}/{snakefile}"
    config: config
use rule * from snowsim as snow_*
rule mine:
    default_target: True
    input: "results/tables/table2.csv"
    output: "mine.txt"
    shell: "cp {{input}} {{output}}"
""")
    done = call(SNAKEMAKE, "--dry-run", "--cores", 1, cwd=tmp_path)
    assert done.returncode == 0, done.stderr[-3000:]
    for job in ("mine", "snow_tabulate_similarity", "snow_train_cgan"):
        assert job in text_of(done)


def test_the_plan_of_the_default_is_built_from_few_jobs(tmp_path):
    # Few enough to follow, and a job takes about a second to start.
    done = run_snakemake(tmp_path, "--dry-run", configs=("config.yaml",))
    n_jobs = int(re.search(r"^total\s+(\d+)$", text_of(done), flags=re.MULTILINE)[1])
    assert 40 < n_jobs <= 75
