"""The report of a run is whole and stands alone."""

import base64
import re

import pytest
import yaml
from runs import ROOT


@pytest.fixture(scope="module")
def page(tiny_run):
    """Text of the report."""
    return (tiny_run / "results/report.html").read_text()


def test_the_page_names_nothing_outside_itself_and_is_small_enough_to_send(page):
    outside = re.findall(r"""(?:src|href|action)\s*=\s*["'](?!data:|#)([^"']+)""", page)
    assert outside == []
    assert "url(" not in page
    assert "@import" not in page
    assert len(page.encode()) < 25e6


def test_the_page_says_that_the_flight_is_synthetic(page):
    assert "No observed radar data were used" in page


def test_every_table_and_figure_of_the_default_run_is_on_the_page(tiny_run, page):
    figures = sorted((tiny_run / "results/figures").iterdir())
    assert figures
    for figure in figures:
        assert f'id="figure-{figure.stem}"' in page
        assert figure.with_suffix(".png").is_file()
    tables = {path.name: path.read_bytes() for path in (tiny_run / "results/tables").glob("*.csv")}
    downloads = dict(re.findall(r'download="([^"]+)" href="data:text/csv;base64,([^"]+)"', page))
    assert tables
    assert {name: base64.b64decode(content) for name, content in downloads.items()} == tables


def test_every_figure_of_the_paper_has_a_counterpart_or_a_reason(page):
    paper = yaml.safe_load((ROOT / "workflow/report/paper.yaml").read_text())
    assert sorted(paper["figures"]) == list(range(1, 13))
    assert "no counterpart in this run" not in page
