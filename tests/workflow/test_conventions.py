"""What people expect of a workflow: named targets, a clean lint, use from another workflow."""

import re
import shutil

from runs import (
    ROOT,
    SNAKEMAKE,
    call,
    copy_source,
    parsed,
    rules_planned,
    run_snakemake,
    source_tree,
    text_of,
)


def test_lint_finds_nothing(tmp_path):
    done = call(SNAKEMAKE, "--lint", "--directory", tmp_path)
    assert "Congratulations, your workflow is in a good condition" in text_of(done)


def test_every_target_is_named_and_described_by_help_in_its_group(tmp_path):
    done = run_snakemake(tmp_path, "--", "help")
    groups = re.findall(
        r"^(main|pretrained|evaluation|studies): .*\n((?:  \w.*\n)*)",
        text_of(done),
        flags=re.MULTILINE,
    )
    assert len(groups) == 4
    listed = {}
    for _, lines in groups:
        listed |= dict(re.findall(r"^  (\w+) {2,}(\S.*)$", lines, flags=re.MULTILINE))
    rules = parsed(tmp_path / "rules").rules
    assert set(listed) == {rule.name for rule in rules if not rule.output} - {"help"}


def test_the_main_path_plans_both_tables_without_what_judges_it(tmp_path):
    source = copy_source(tmp_path / "source")
    shutil.rmtree(source / "workflow/evaluation")
    planned, _ = rules_planned(tmp_path / "run", source=source)
    assert {"tabulate_similarity", "tabulate_trackers", "render_phy", "render_cgan"} <= planned
    assert not {name for name in planned if name.startswith(("plot_", "measure_", "compare_"))}


def test_every_job_of_every_target_has_its_settings(tmp_path):
    names = {rule.name for rule in parsed(tmp_path).rules if not rule.output}
    # Of own frames, which the synthetic flight has none of.
    targets = names - {"help", "picks"}
    jobs = {job.rule.name for job in parsed(tmp_path, targets=targets).dag.jobs}
    assert {"score_transfer", "tabulate_choices", "tabulate_compute", "fly", "ship_tracker"} <= jobs


def test_another_workflow_can_use_this_one_as_a_module(tmp_path):
    shutil.copy2(ROOT / "config/config.yaml", tmp_path / "config.yaml")
    (tmp_path / "Snakefile").write_text(f"""\
configfile: "config.yaml"
module snowsim:
    snakefile: "{source_tree()}/workflow/Snakefile"
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
    # The report finds jobs by the names of their logs, which a module keeps.
    stages = parsed(tmp_path, (), snakefile=tmp_path / "Snakefile").get_rule("snow_write_report")
    assert stages.params.rule_stages["train_cgan"] == "renders"
