"""What the page is made of: captions, comparisons, costs, scenes, embedded files, templates."""

import base64
import io
import re

import jinja2
import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose
from PIL import Image
from result_tables import SETS, table2, table3_intervals, worth

from evaluation.lib.figures.style import evenly_spaced
from evaluation.lib.report import content
from evaluation.lib.report.content import (
    compare_table2,
    compare_table3,
    paper_figures,
    stage_costs,
    title_of,
)
from evaluation.lib.report.format import config_lines, duration, groupby_stage, size
from evaluation.lib.report.gallery import depth_scale, layer_lines
from evaluation.lib.report.page import figure_uri, file_uri, image_uri, read_benchmarks, write_page


@pytest.mark.parametrize(
    ("caption", "numbers"),
    [
        ("Spectra (paper, Fig. 8), and more.", [8]),
        ("Mean waveform (paper, Figs 6 and 7).", [6, 7]),
        ("Several (paper, Figs 10-12).", [10, 11, 12]),
        ("Several (paper, Figs 1, 2 and 9).", [1, 2, 9]),
        ("A figure of ours, Fig. 3 of nothing.", []),
    ],
)
def test_a_caption_names_the_paper_s_figures(caption, numbers):
    assert paper_figures(caption) == numbers
    found = content.counterparts([{"name": "x", "caption": caption}], range(1, 13))
    assert [number for number, figures in found.items() if figures] == numbers


def test_a_title_is_the_first_clause_without_the_paper_s_figure():
    assert (
        title_of("Where frames lie (paper, Fig. 4). The coast\n is schematic.")
        == "Where frames lie"
    )
    assert title_of("Closed loop: statistics of 0.5 dB.") == "Closed loop"
    assert (
        title_of("Time (fastest of 27 runs; all in the table) of a scene. More.")
        == "Time of a scene"
    )
    assert title_of("Errors of 0.5 dB and more") == "Errors of 0.5 dB and more"
    assert len(title_of("word " * 60)) <= 114


def test_table2_stands_beside_the_paper_s():
    paper = {metric: {"cgan": [7, 8, 9], "phy": [4, 5, 6]} for metric in ("ssim", "psnr", "rmse")}
    rows = compare_table2(table2([1, 2, 3], [2, 4, 6]), paper)
    ours, published = "2.00 / 4.00 / 6.00", "4.00 / 5.00 / 6.00"
    assert rows[1] == {
        "metric": "SSIM",
        "method": "PHY",
        "ours": ours,
        "printed": "",
        "paper": published,
    }


def test_the_run_as_printed_stands_beside_the_run(planted_page):
    text = planted_page.read_text()
    assert text.count("<em>0.123</em>") == 6 * 4 * 3  # every cell of Table III
    assert '<td class="num">0.20 / 0.20 / 0.20</td>' in text
    assert "indicative only" in text


def test_errors_of_picks_stand_beside_edge_scores(planted_page):
    rows = re.findall(
        r'<th scope="row">([^<]*)</th>((?:<td class="num">[^<]*</td>)+)</tr>',
        planted_page.read_text(),
    )
    cells = {name: re.findall(r">([^<]+)<", found) for name, found in rows}
    assert cells["Mean absolute error [range bins]"] == ["1.00"] * 4
    assert cells["Share of errors within 2 range bins"] == ["0.900"] * 4
    assert cells["Layers missed, of 40"] == ["5"] * 4


def test_table3_marks_what_is_resolved():
    intervals = table3_intervals(
        {("fuse", "rd_gd"): 0.02, ("fuse", "rd_pd_gd"): -0.02}, 0.01, outputs=["fuse"]
    )
    compared = compare_table3(intervals, {"fuse": {name: [0.1, 0.2, 0.3] for name in SETS}})
    assert [row["score"] for row in compared] == ["ODS", "OIS", "AP"]
    assert [cell["resolved"] for cell in compared[0]["cells"]] == [False, True, False, True]
    assert [row["cells"][0]["paper"] for row in compared] == [0.1, 0.2, 0.3]


@pytest.mark.parametrize("n_replicas", [2, 5])
def test_the_fused_output_s_differences_are_the_study_s_where_it_has_more_trainings(
    n_replicas, tmp_path
):
    path = tmp_path / "studies/tracker/worth.csv"
    path.parent.mkdir(parents=True)
    worth(n_replicas, mean=0.9, base_mean=0.7, difference=0.2, low=0.1, high=0.3).to_csv(
        path, index=False
    )
    intervals = table3_intervals()
    shown = content.with_study(intervals, [str(path)])[intervals.columns]
    fuse = shown["output"] == "fuse"
    pd.testing.assert_frame_equal(shown[~fuse], intervals[~fuse])
    if n_replicas == 2:
        return pd.testing.assert_frame_equal(shown, intervals)
    added = shown[fuse & (shown["training_set"] != "rd")]
    assert (
        added[["mean", "difference", "difference_low", "difference_high"]] == [0.9, 0.2, 0.1, 0.3]
    ).all(axis=None)
    assert (shown.loc[fuse, "n_replicas"] == 5).all()
    assert (shown.loc[fuse & (shown["training_set"] == "rd"), "mean"] == 0.7).all()


def test_stages_cost_what_their_rules_cost(tmp_path):
    for name, seconds in (
        ("draw/0.tsv", 2.0),
        ("draw/deep/1.tsv", 3.0),
        ("plot/all.tsv", 1.0),
        ("gone/all.tsv", 99.0),
    ):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"s\th:m:s\tmax_rss\tcpu_time\n{seconds}\t0:00:02\t512.0\t{seconds / 2}\n")
    path.write_text("s\th:m:s\tmax_rss\tcpu_time\n99\t0:01:39\t-\t-\n")
    costs = stage_costs(
        read_benchmarks(tmp_path), {"draw": "labels", "plot": "labels", "unseen": "phy"}
    )
    assert [stage["stage"] for stage in costs] == ["labels"]
    assert costs[0]["n_jobs"] == 3
    assert (costs[0]["wall_s"], costs[0]["cpu_s"], costs[0]["memory_gb"]) == (6.0, 3.0, 0.5)
    assert [rule["wall_s"] for rule in costs[0]["rules"]] == [5.0, 1.0]
    assert stage_costs(read_benchmarks(tmp_path / "none"), {"draw": "labels"}) == []


def test_scenes_spread_over_the_number_of_layers_and_lines_break_where_one_is_absent():
    n_layers = np.random.default_rng(5).permutation(40)
    chosen = evenly_spaced(n_layers, 5)
    assert [int(n_layers[i]) for i in chosen] == [0, 10, 20, 29, 39]
    assert sorted(evenly_spaced([3, 1, 2], 16)) == [0, 1, 2]
    layer = np.array([[1.04, 2.0, np.nan, 4.0, 5.0, np.nan, np.nan, 8.0]])
    assert layer_lines(layer, step=1) == [[[0.0, 1.0, 1.0, 2.0], [3.0, 4.0, 4.0, 5.0], [7.0, 8.0]]]
    assert layer_lines(np.arange(6.0)[None], step=4) == [[[0.0, 0.0, 4.0, 4.0, 5.0, 5.0]]]


def test_depths_of_the_gallery_are_those_of_the_configuration_s_snow():
    scale = depth_scale(bin_size_s=2.886e-10, snow_density_kg_m3=340)
    assert scale["air_per_bin_m"] == 299_792_458 * 2.886e-10 / 2
    # Kovacs et al. (1995): the index is 1 + 0.845 times the density in g / cm3.
    assert_allclose(scale["air_per_bin_m"] / scale["snow_per_bin_m"], 1 + 0.845 * 0.34, rtol=1e-14)


def decoded(uri):
    return base64.b64decode(uri.split(",", 1)[1])


def test_an_embedded_image_is_the_image_but_for_compression_and_grey(rng):
    smooth = np.clip(
        128 + 100 * np.sin(np.arange(64)[:, None] / 9 + np.arange(48) / 7), 0, 255
    ).astype(np.uint8)
    with Image.open(io.BytesIO(decoded(image_uri(smooth)))) as image:
        back = np.asarray(image.convert("L")).astype(float)
    # WebP of quality 65 on a smooth image: about 1 grey level; an image upside down would be off by
    # 70.
    assert np.sqrt(np.mean((back - smooth) ** 2)) < 3
    with pytest.raises(ValueError, match="uint8 and 2-D, got float64"):
        image_uri(np.zeros((4, 4)))


def test_files_are_embedded_byte_for_byte_and_a_large_figure_becomes_pixels(tmp_path):
    path = tmp_path / "t.csv"
    path.write_bytes(b"a,b\n1,2\n")
    assert decoded(file_uri(path)) == b"a,b\n1,2\n"
    with pytest.raises(ValueError, match=r"t\.txt: expected"):
        file_uri(tmp_path / "t.txt")
    svg = tmp_path / "f.svg"
    svg.write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    Image.new("RGB", (40, 30), "white").save(tmp_path / "f.png")
    assert figure_uri(svg).startswith("data:image/svg+xml;")
    assert figure_uri(svg, most_bytes=10).startswith("data:image/webp;")


def test_a_template_s_unknown_name_leaves_no_page_and_text_from_tables_is_no_markup(tmp_path):
    (tmp_path / "p.j2").write_text("{{ known }} {{ unknown }}")
    with pytest.raises(jinja2.UndefinedError, match="unknown"):
        write_page(tmp_path / "p.html", tmp_path, "p.j2", {"known": 1}, {})
    assert [path.name for path in tmp_path.iterdir()] == ["p.j2"]
    (tmp_path / "p.html.j2").write_text("{{ text }}")
    write_page(tmp_path / "p.html", tmp_path, "p.html.j2", {"text": "<script>"}, {})
    assert (tmp_path / "p.html").read_text() == "&lt;script&gt;"


def test_settings_have_their_full_names_and_durations_and_sizes_read_well():
    config = {"seed": 1, "phy": {"align": "peak", "deep": {"x": [1, 2]}}, "empty": {}}
    assert config_lines(config) == [
        ("seed", "1"),
        ("phy.align", "peak"),
        ("phy.deep.x", "[1, 2]"),
        ("empty", "{}"),
    ]
    assert [duration(s) for s in (1.23, 45.2, 200, 7500)] == [
        "1.2 s",
        "45 s",
        "3 min 20 s",
        "2 h 5 min",
    ]
    assert [size(n) for n in (820, 12_000, 1_340_000)] == ["820 B", "12 kB", "1.3 MB"]


def test_figures_of_a_stage_stand_together_in_the_order_stages_come():
    figures = [{"stage": stage} for stage in ("tracker", "labels", "tracker")]
    assert [(stage, len(group)) for stage, group in groupby_stage(figures)] == [
        ("tracker", 2),
        ("labels", 1),
    ]


def test_the_page_shows_figures_and_what_studies_made_with_their_study_s_name(planted_page):
    text = planted_page.read_text()
    assert re.findall(r'id="figure-(\w+)"', text) == ["wave", "fall"]
    assert '<h3 id="stage-flight">The flight and its statistics</h3>' in text
    assert "<h3>Seeds</h3>" in text
    assert text.count("0.80 [0.70, 0.90]") == 6
    assert 'download="seeds_spread.csv"' in text
