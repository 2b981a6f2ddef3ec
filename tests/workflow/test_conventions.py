"""What people expect of a workflow: named targets, a clean lint, described keys, use from another workflow."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from runs import ROOT, SNAKEMAKE, environment, run_snakemake, source_tree

TARGETS = {
    "all",
    "flight",
    "labels",
    "renders",
    "similarity",
    "trackers",
    "charts",
    "stability",
    "report",
    "export",
    "studies",
}


def call(*words, cwd, timeout=300):
    words = [str(word) for word in words]
    return subprocess.run(
        words, capture_output=True, text=True, cwd=cwd, timeout=timeout, check=False, env=environment()
    )


def test_lint_finds_nothing(tmp_path):
    done = call(SNAKEMAKE, "--lint", "--directory", tmp_path, cwd=source_tree())
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Congratulations, your workflow is in a good condition" in done.stdout + done.stderr


def test_rules_are_formatted():
    pytest.importorskip("snakefmt")
    done = call(SNAKEMAKE.with_name("snakefmt"), "--check", "Snakefile", "workflow", cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr


def test_every_target_is_named_and_described_by_help(rules, tmp_path):
    done = run_snakemake(tmp_path, "--", "help")
    assert done.returncode == 0, done.stderr[-2000:]
    listed = dict(re.findall(r"^  (\w+) {2,}(\S.*)$", done.stdout + done.stderr, flags=re.MULTILINE))
    assert set(listed) >= TARGETS
    assert set(listed) == {rule.name for rule in rules if not rule.declared.output} - {"help"}
    # A name alone, or Python's None, describes nothing.
    assert all(len(text.split()) > 2 for text in listed.values()), listed


def test_targets_run_where_snakemake_runs(rules):
    # On a cluster a target that only collects files is no job of its own.
    for rule in rules:
        if not rule.declared.output:
            assert rule.declared.workflow.is_local(rule.declared), f"{rule.name} belongs to localrules"


def test_targets_can_be_planned_by_name(tmp_path):
    done = run_snakemake(tmp_path, "--dry-run", "--quiet", "--", *sorted(TARGETS))
    assert done.returncode == 0, done.stderr[-2000:]


def test_studies_collects_every_study(rules):
    studies = {rule.name for rule in rules if rule.name.startswith("study_") and not rule.declared.output}
    files = {path.stem for path in (ROOT / "workflow/rules").glob("study_*.smk")}
    assert files <= studies


def keys_of(mapping, before=()):
    for key, value in mapping.items():
        yield (*before, key)
        if isinstance(value, dict):
            yield from keys_of(value, (*before, key))


def test_the_default_holds_every_key_of_the_schema_and_the_page_every_key_of_the_default():
    schema = json.loads((ROOT / "workflow/schemas/config.schema.json").read_text())
    config = yaml.safe_load((ROOT / "config/config.yaml").read_text())
    page = (ROOT / "config/README.md").read_text()
    for keys in keys_of(config):
        part = schema
        for key in keys:
            assert "properties" in part, f"{keys}: no such section in the schema"
            part = part["properties"][key]
        assert f"| `{keys[-1]}` |" in page or f"# {'.'.join(keys)}\n" in page, keys
        assert part.get("description"), f"{'.'.join(keys)} has no description"


def test_the_catalogue_knows_how_to_run_the_workflow():
    usage = yaml.safe_load((ROOT / ".snakemake-workflow-catalog.yml").read_text())["usage"]
    assert usage["software-stack-deployment"]["conda"] is True
    assert usage["report"] is True
    assert (ROOT / "config/README.md").is_file()
    assert (ROOT / "workflow").is_dir()


def test_another_workflow_can_use_this_one_as_a_module(tmp_path):
    shutil.copy2(ROOT / "config/config.yaml", tmp_path / "config.yaml")
    (tmp_path / "Snakefile").write_text(f"""\
configfile: "config.yaml"
module snowsim:
    snakefile: "{source_tree()}/Snakefile"
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
    jobs = done.stdout + done.stderr
    assert "mine" in jobs
    assert "snow_tabulate_similarity" in jobs
    assert "snow_train_cgan" in jobs


def test_the_report_needs_no_network(tiny_run, tmp_path):
    alone = ["unshare", "--net", "--map-root-user"]
    if shutil.which("unshare") is None or subprocess.run([*alone, "true"], check=False).returncode != 0:
        alone = []
    page = tmp_path / "report.html"
    done = call(
        *alone,
        *(sys.executable, "-m", "snakemake", "--snakefile", source_tree() / "Snakefile", "--directory", tiny_run),
        *("--cores", 1, "--configfile", ROOT / "config/config.yaml", ROOT / "config/tiny.yaml", "--report", page),
        cwd=source_tree(),
    )
    assert done.returncode == 0, done.stderr[-3000:]
    text = page.read_text()
    assert "table3.svg" in text
    assert "Precision against recall of the fused output, four training sets." in text
    assert not re.findall(r"<(?:script|link|img)[^>]+(?:src|href)=[\"']https?:", text)


def test_the_plan_of_the_default_is_built_from_few_jobs(tmp_path):
    # A job takes about a second to start: of 150 that is a tenth of what they work on two cores.
    done = run_snakemake(tmp_path, "--dry-run", configs=("config.yaml",))
    n_jobs = int(re.search(r"^total\s+(\d+)$", done.stdout + done.stderr, flags=re.MULTILINE)[1])
    assert 50 < n_jobs < 150


def test_profiles_and_environments_lie_where_snakemake_looks():
    for name in ("default", "slurm"):
        profile = yaml.safe_load((ROOT / f"profiles/{name}/config.yaml").read_text())
        assert profile["scheduler"] == "greedy"
        assert "params" in profile["rerun-triggers"]
    assert Path(ROOT / "envs/cpu.yaml").is_file()
