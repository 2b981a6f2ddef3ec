"""A report of planted tables, figures and scenes: seconds instead of a run of the workflow."""

import pandas as pd
import pytest
from processes import ROOT
from result_tables import closed_loop, picks, table2, table3_equal, table3_intervals
from toy_scenes import toy_scene

from evaluation.lib.figures.style import METHODS, new_panel, save_figure
from evaluation.lib.report import (
    depth_scale,
    figures_by_stage,
    gallery_of,
    page_content,
    write_page,
)
from snowsim.io import read_table

REPORT = ROOT / "workflow/evaluation/report"


@pytest.fixture(scope="session")
def planted_tables():
    """Tables of a run, by name."""
    two_sample = pd.DataFrame({"scenes": ["observed", "phy", "cgan"]})
    return {
        "table2": table2([0.4] * 3, [0.5] * 3),
        "table3_intervals": table3_intervals({("fuse", "rd_pd"): 0.02}),
        "table3_equal": table3_equal(rd=0.79, rd_pd=0.83),
        "picks": picks(),
        "two_sample": two_sample.assign(
            classifier="network", first_row=-1, accuracy=0.8, low=0.7, high=0.9
        ),
        "closed_loop": closed_loop(),
    }


@pytest.fixture(scope="session")
def paper():
    """The paper's Tables II and III, by name."""
    return {path.stem: read_table(path) for path in (REPORT / "paper").iterdir()}


@pytest.fixture(scope="session")
def planted_page(planted_tables, paper, tmp_path_factory):
    """A report of planted tables, scenes and a figure."""
    folder = tmp_path_factory.mktemp("report")
    figure, ax = new_panel()
    ax.plot([1, 3, 2])
    save_figure(folder / "wave.svg", figure, "planted")
    caption = folder / "wave.rst"
    caption.write_text("A wave (paper, Fig. 6).\n\nUp is\nmore.\n")
    # The higher its number, the more layers and bins.
    scenes = [toy_scene(n, 300 + 200 * n, 256, 3 * n + 1) for n in range(4)]
    rows = [(scene.name, method, 0.4, 20.0) for scene in scenes for method in METHODS]
    images = pd.DataFrame(rows, columns=["scene", "method", "ssim", "psnr"])
    job = {"stage": "labels", "rule": "draw_labels", "s": 2.0, "max_rss": 512.0}
    config = {"seed": 7, "source": "reference", "phy": {"n_looks": 16}}
    warned = pd.DataFrame(
        {"Rule": ["draw_labels"], "Warning": ["9 of 40 lines <are> thin"], "Jobs": [2]}
    )
    jobs = pd.DataFrame([job])
    content = page_content(
        planted_tables, paper, {}, jobs, warned, config, "synthetic reference flight"
    )
    content["figures"] = figures_by_stage([folder / "wave.svg"], ["flight"], [caption])
    shown = gallery_of({"observed": scenes, "cgan": scenes, "phy": scenes}, images)
    content["gallery"] = {"scenes": shown, **depth_scale(2.886e-10, 340)}
    write_page(folder / "report.html", REPORT / "page/page.html.j2", content)
    return folder / "report.html"
