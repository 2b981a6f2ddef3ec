"""What the page is made of: comparisons, costs, layers as lines."""

import re

import numpy as np
import pandas as pd
import pytest
from processes import ROOT
from result_tables import closed_loop, table2, table3_intervals

from evaluation.lib.report import (
    compare_table2,
    compare_table3,
    costs,
    layer_lines,
    over_flights,
    page_content,
    read_benchmarks,
    read_warnings,
    recovered,
    result,
)


def test_table2_stands_beside_other_sources(paper):
    rows = compare_table2({"ours": table2([1, 2, 3], [2, 4, 6]), "paper": paper["table2"]})
    phy = {"ours": "2.00 / 4.00 / 6.00", "paper": "0.31 / 0.51 / 0.63"}
    assert rows[0]["cells"][1] == phy


@pytest.mark.parametrize(
    ("gain", "verdict"),
    [(0.02, "the trackers of this run are better."), (0.004, "no gain is shown.")]
    + [(-0.02, "the trackers of this run are worse.")],
)
def test_the_result_says_whether_a_gain_is_shown(gain, verdict):
    # The interval reaches .005 to both sides.
    words = result(table3_intervals({("fuse", "rd_pd"): gain}))
    assert words.endswith(verdict)
    assert f"fused ODS of {0.8 + gain:.3f} on the 60 test scenes" in words


def test_the_page_opens_with_the_result_and_its_control(planted_page):
    _, summary = planted_page.read_text().split('<section id="summary"')
    found, control = re.findall(r"<p[^>]*>([^<]*)</p>", summary)[:2]
    assert "(RD+PD) have a fused ODS of 0.820" in found
    assert "ODS is 0.790 (with its own number 0.800)" in control
    assert "that of RD+PD with as many is 0.830" in control


def test_the_study_s_endpoint_and_secondary_pairs_are_shown():
    rows = [("rd_pd", "rd_sample", "endpoint", "ods"), ("rd_pd", "rd_sample", "endpoint", "ap")]
    rows += [("rd_pd", "rd", "secondary", "ods"), ("pd", "rd", "exploratory", "ods")]
    rows += [("rd", np.nan, np.nan, "ods")]
    worth = pd.DataFrame(rows, columns=["training_set", "base", "role", "metric"])
    shown = over_flights(worth.assign(mean=0.01, low=-0.01, high=0.03)).to_numpy().tolist()
    value = "+0.010 [\u22120.010, +0.030]"
    assert shown == [
        ["RD+PD less RD + sample flight", "endpoint", value],
        ["RD+PD less RD", "secondary", value],
    ]


def test_side_outputs_come_after_the_fused_one_and_fold(planted_page):
    text = planted_page.read_text()
    names = re.findall(r'<th scope="row">((?:fuse|side \d), \w+)</th>', text)
    assert names[:4] == ["fuse, ODS", "fuse, OIS", "fuse, AP", "side 1, ODS"]
    folded = text.index("<details><summary>Side outputs")
    assert text.index("fuse, AP") < folded < text.index("side 1, ODS")


def test_every_caption_says_what_a_figure_shows_and_how_to_read_it():
    for path in (ROOT / "workflow/evaluation/report/captions").iterdir():
        sentences = path.read_text().strip().split("\n\n")
        assert len(sentences) == 2, path.name
        for sentence in sentences:
            # One sentence: no full stop before another capital but that of an abbreviation.
            words = re.sub(r"\b(Figs?|eq)\.", "", " ".join(sentence.split()))
            assert re.search(r"\.\s+[A-Z]", words) is None, path.name
            assert words.endswith("."), path.name


def test_table3_marks_what_is_resolved_beside_the_paper_s(paper):
    planted = {("fuse", "rd_gd"): 0.02, ("fuse", "rd_pd_gd"): -0.02}
    intervals = table3_intervals(planted, 0.01, outputs=["fuse"])
    rows = compare_table3(intervals, {"paper": paper["table3"].set_index("output")})
    cells = rows[0]["cells"]
    assert [cell["paper"] for cell in cells] == ["0.815", "0.825", "0.829", "0.825"]
    assert [cell["resolved"] for cell in cells[1:]] == [True, False, True]
    assert cells[3]["difference"] == "\u22120.020 [\u22120.030, \u22120.010]"


def test_the_run_as_printed_stands_beside_a_run_without_measured_times(
    planted_tables, paper, tmp_path
):
    jobs = read_benchmarks(tmp_path, {})
    config = {"seed": 1, "source": "nsidc"}
    content = page_content(
        planted_tables, paper, paper, jobs, read_warnings(tmp_path, {}), config, "own data"
    )
    for row in [*content["table2"], *content["table3"]]:
        assert all(cell["printed"] == cell["paper"] for cell in row["cells"])


def test_the_page_shows_tables_figures_and_that_the_flight_is_synthetic(planted_page):
    text = planted_page.read_text()
    assert "No observed radar data were used." in text
    rows = re.findall(r'<th scope="row">([^<]*)</th>((?:<td>[^<]*</td>)+)</tr>', text)
    cells = {name: re.findall(r">([^<]+)<", found) for name, found in rows}
    assert cells["Mean absolute error [range bins]"] == ["1.00"] * 4
    assert cells["cGAN"] == ["0.80 [0.70, 0.90]"]
    assert cells["Label sets"] == ["1", "2 s", "100%", "0.5 GiB"]
    assert cells["phy.n_looks"] == ["16"]
    assert cells["draw_labels"] == ["9 of 40 lines &lt;are&gt; thin", "2"]
    assert "<h3>The flight and its statistics</h3>" in text
    assert "<strong>A wave (paper, Fig. 6).</strong> Up is\nmore." in text


def test_the_closed_loop_is_a_row_a_quantity():
    rows = recovered(closed_loop()).to_numpy().tolist()
    assert rows == [
        ["peak power", 2, "3.0%", "3.0%", "0.50"],
        ["width bins", 1, "1.0 bins", "1.0 bins", "1.00"],
    ]


def test_stages_cost_what_their_rules_cost(tmp_path):
    for name, row in {
        "draw/0.tsv": "2.0\t512.0",
        "plot/all.tsv": "15.0\t-",
    }.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("s\tmax_rss\n" + row)
    jobs = read_benchmarks(tmp_path, {"draw": "labels", "plot": "labels"})
    of_stages = costs(jobs, "stage").to_numpy().tolist()
    assert of_stages == [["Label sets", 2, "17 s", "100%", "0.5 GiB"]]
    plot, _ = costs(jobs, "rule").to_numpy().tolist()
    assert plot == ["plot", 1, "15 s", "88%", ""]


def test_warnings_of_logs_are_listed_once_a_rule_with_the_number_of_jobs(tmp_path):
    for name, lines in {
        "draw.log": ["warning: thin layers", "done in 2 s", "warning: thin layers"],
        "cut/train/0000.log": ["warning: thin layers", "warning: RuntimeWarning: divided by zero"],
        "cut/test/0001.log": ["warning: thin layers"],
        "as_printed/draw.log": ["warning: of another run"],
    }.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("".join(f"2026-01-02 03:04:05,678 {line}\n" for line in lines))
    found = read_warnings(tmp_path, {"draw": "labels", "cut": "flight"})
    assert found.to_numpy().tolist() == [
        ["cut", "thin layers", 2],
        ["cut", "RuntimeWarning: divided by zero", 1],
        ["draw", "thin layers", 1],
    ]


def test_lines_break_where_a_layer_is_absent():
    layer = np.array([[1.04, 2.0, np.nan, 4.0, 5.0, np.nan, np.nan, 8.0]])
    assert layer_lines(layer, step=1) == [[[0.0, 1.0, 1.0, 2.0], [3.0, 4.0, 4.0, 5.0], [7.0, 8.0]]]
    assert layer_lines(np.arange(6.0)[None], step=4) == [[[0.0, 0.0, 4.0, 4.0, 5.0, 5.0]]]
