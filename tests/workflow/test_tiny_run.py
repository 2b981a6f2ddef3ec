"""The tiny configuration through every rule: tables, figures, and a report that stands alone."""

import html
import re
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from PIL import Image
from result_tables import METRICS, OUTPUTS, SETS
from runs import TINY, run_snakemake

from snowsim.io import SceneSet


def test_both_tables_are_complete(tiny_run):
    table2 = pd.read_csv(tiny_run / "results/tables/table2.csv")
    assert table2.shape == (9, 4)
    assert table2.notna().all(axis=None)
    table3 = pd.read_csv(tiny_run / "results/tables/table3.csv")
    assert list(table3["output"]) == list(OUTPUTS)
    scores = table3.drop(columns="output")
    assert {f"{name}_{metric}" for name in SETS for metric in METRICS} <= set(scores)
    assert scores.stack().between(0, 1).all()


def test_every_label_set_is_rendered_by_both_methods_at_its_own_height(tiny_run):
    folders = (tiny_run / "results" / name for name in ("labels", "phy/labels", "cgan/labels"))
    labels, phy, cgan = (SceneSet(sorted(folder.glob("*.nc"))) for folder in folders)
    assert len(labels) == len(phy) == len(cgan) > 0
    for label, by_phy, by_cgan in zip(labels, phy, cgan, strict=True):
        assert label.name == by_phy.name == by_cgan.name
        size = (label.n_range_bins, label.n_range_lines)
        assert by_phy.image.shape == by_cgan.image.shape == size


@pytest.fixture(scope="module")
def page(tiny_run):
    """Text of the report."""
    return (tiny_run / "results/report.html").read_text()


def test_the_page_lists_every_rule_and_every_warning_of_the_logs(page, tiny_run):
    for folder in (tiny_run / "results/benchmarks").iterdir():
        if folder.name != "write_report":  # not over yet
            assert f'<th scope="row">{folder.name}</th>' in page
    warned = [
        line.partition(" warning: ")[2]
        for path in (tiny_run / "logs").rglob("*.log")
        for line in path.read_text().splitlines()
        if " warning: " in line
    ]
    assert any("layer" in line for line in warned)
    for line in warned:
        assert f"<td>{line}</td>" in html.unescape(page)


def test_the_page_is_of_a_synthetic_flight_and_stands_alone(page):
    assert "No observed radar data were used" in page
    outside = re.findall(r"""(?:src|href|action)\s*=\s*["'](?!data:|#)([^"']+)""", page)
    assert outside == []
    assert "url(" not in page
    assert "@import" not in page
    assert len(page.encode()) < 25e6


def test_every_figure_decodes_and_is_on_the_page(tiny_run, page):
    figures = sorted((tiny_run / "results/figures").iterdir())
    shown = re.findall(r"<code>(\w+)\.(?:svg|png)</code></figcaption>", page)
    assert sorted(shown) == sorted({figure.stem for figure in figures})
    for figure in figures:
        with Image.open(figure.with_suffix(".png")) as image:
            assert np.asarray(image).std() > 0
        if figure.suffix == ".svg":
            assert ElementTree.parse(figure).getroot().tag.endswith("svg")


@pytest.mark.gpu
def test_the_tiny_run_trains_and_renders_on_a_gpu(tmp_path):
    on_gpu = tmp_path / "gpu.yaml"
    on_gpu.write_text("{cgan: {device: cuda}, tracker: {device: cuda}}")
    run_snakemake(tmp_path, "--resources", "gpu=1", configs=(*TINY, on_gpu))
    assert len(pd.read_csv(tmp_path / "results/tables/table3.csv")) == len(OUTPUTS)
