"""The report of a run is whole and stands alone."""

import base64
import re
import shutil
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def page_path(tiny_run, tmp_path_factory):
    """The report alone, away from the run that made it."""
    copy = tmp_path_factory.mktemp("page") / "report.html"
    shutil.copy(tiny_run / "results/report.html", copy)
    return copy


def test_the_page_names_nothing_outside_itself(page_path):
    text = page_path.read_text()
    outside = re.findall(r"""(?:src|href|action)\s*=\s*["'](?!data:|#)([^"']+)""", text)
    assert outside == []
    assert "url(" not in text
    assert "@import" not in text


def test_the_page_says_that_the_flight_is_synthetic(page_path):
    assert "No observed radar data were used" in page_path.read_text()


def test_the_page_is_small_enough_to_send(page_path):
    assert page_path.stat().st_size < 25e6


def test_every_table_and_figure_of_the_default_run_is_on_the_page(tiny_run, page_path):
    text = page_path.read_text()
    for table in sorted((tiny_run / "results/tables").glob("*.csv")):
        assert f'download="{table.name}"' in text
    figures = sorted((tiny_run / "results/figures").iterdir())
    assert figures
    for figure in figures:
        assert f'id="figure-{figure.stem}"' in text
        assert figure.with_suffix(".png").is_file()


def test_every_figure_of_the_paper_has_a_counterpart_or_a_reason(page_path):
    paper = yaml.safe_load((ROOT / "workflow/report/paper.yaml").read_text())
    assert sorted(paper["figures"]) == list(range(1, 13))
    assert "no counterpart in this run" not in page_path.read_text()


def test_downloads_are_the_tables_byte_for_byte(tiny_run, page_path):
    found = dict(re.findall(r'download="([^"]+)" href="data:text/csv;base64,([^"]+)"', page_path.read_text()))
    assert found
    for name, content in found.items():
        assert base64.b64decode(content) == (tiny_run / "results/tables" / name).read_bytes()
