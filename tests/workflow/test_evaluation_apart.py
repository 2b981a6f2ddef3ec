"""The main path without the evaluation; a figure's way from its file to what draws it."""

import re
import shutil
from pathlib import Path

import pytest
from runs import ROOT, copy_source, rules_to_run, run_snakemake

CAPTIONS = ROOT / "workflow/evaluation/report/captions"


@pytest.fixture(scope="module")
def main_path(tmp_path_factory):
    """A copy of the workflow without what judges and shows it."""
    folder = copy_source(tmp_path_factory.mktemp("main_path") / "source")
    shutil.rmtree(folder / "workflow/evaluation")
    return folder


def test_the_main_path_plans_both_tables_without_the_evaluation(main_path, tmp_path):
    planned = rules_to_run(run_snakemake(tmp_path, "--dry-run", source=main_path))
    assert {"tabulate_similarity", "tabulate_trackers", "render_phy", "render_cgan"} <= planned
    assert not {name for name in planned if name.startswith(("plot_", "measure_", "compare_"))}


@pytest.mark.slow
def test_the_main_path_runs_without_the_evaluation_to_the_same_tables(
    main_path, tiny_run, tmp_path
):
    run_snakemake(tmp_path, source=main_path, timeout=3600)
    for name in ("table2", "table3", "table3_intervals", "ssim_depth", "picks"):
        table = f"results/tables/{name}.csv"
        assert (tmp_path / table).read_bytes() == (tiny_run / table).read_bytes(), name
    assert not (tmp_path / "results/figures").exists()


def test_the_rule_of_a_figure_names_its_script_and_that_the_function_of_the_figure_s_name(rules):
    captions = set()
    for rule in rules:
        if rule.name.startswith("plot_"):
            assert rule.script.stem == rule.name
            drawing = rule.script.read_text()
            figures = [Path(file) for file in rule.declared.output if "figures" in file]
            assert figures
            for figure in figures:
                output = figure.name.replace(".", "_")
                assert re.search(rf"save_figure\(\s*{output},", drawing), output
                assert f".{figure.stem}(" in drawing
                captions.add(f"{figure.stem}.rst")
    assert captions == {path.name for path in CAPTIONS.iterdir()}


@pytest.mark.parametrize("path", sorted(CAPTIONS.iterdir()), ids=lambda path: path.stem)
def test_a_caption_is_whole_sentences(path):
    caption = path.read_text().strip()
    assert caption.endswith(".")
    assert len(caption.split()) > 3
