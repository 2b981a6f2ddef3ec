"""A report of planted tables, figures and scenes: seconds instead of a run of the workflow."""

from itertools import product

import numpy as np
import pandas as pd
import pytest
from result_tables import OUTPUTS, SETS, picks, table2, table3_intervals

from evaluation.lib.figures.style import METHODS, new_figure, write_figure
from evaluation.lib.report.content import page_content
from evaluation.lib.report.format import FILTERS
from evaluation.lib.report.gallery import depth_scale, gallery_of
from evaluation.lib.report.page import write_page
from lib.imports import ROOT
from snowsim.echogram import Scene
from snowsim.io.files import write_table

REPORT = ROOT / "workflow/evaluation/report"


def planted_scene(number, rng):
    """A scene of the gallery: layers that grow in number, noise that darkens with depth."""
    n_bins, n_lines, n_layers = 300 + 200 * number, 256, 3 * number
    layers = 50 + 4 * np.sin(np.arange(n_lines) / 20) + 12.0 * np.arange(n_layers + 1)[:, None]
    layers[-1, 100:140] = np.nan
    noisy = np.linspace(230, 60, n_bins)[:, None] + rng.normal(0, 12, (n_bins, n_lines))
    return Scene(
        f"test_{number:04d}", n_bins, layers, image=np.clip(noisy, 0, 255).astype(np.uint8)
    )


@pytest.fixture(scope="session")
def planted_tables(tmp_path_factory):
    """Folder of the tables that a report cannot do without."""
    folder = tmp_path_factory.mktemp("tables")
    write_table(folder / "table2.csv", table2([0.4] * 3, [0.5] * 3))
    differences = {
        (output, name): 0.01 * place for output in OUTPUTS for place, name in enumerate(SETS)
    }
    write_table(folder / "table3_intervals.csv", table3_intervals(differences))
    rows = [
        (name, how, -1, 0.8, 0.7, 0.9)
        for name in ("observed", "phy", "cgan")
        for how in ("network", "texture")
    ]
    columns = ["scenes", "classifier", "first_row", "accuracy", "low", "high"]
    write_table(folder / "two_sample.csv", pd.DataFrame(rows, columns=columns))
    write_table(folder / "picks.csv", picks())
    long_names = {f"a_column_with_quite_a_long_name_{k}": np.arange(30) / 7 for k in range(12)}
    write_table(folder / "wide.csv", pd.DataFrame(long_names))
    return folder


@pytest.fixture(scope="session")
def planted_page(planted_tables, tmp_path_factory):
    """A report of planted tables."""
    folder = tmp_path_factory.mktemp("page")
    rng = np.random.default_rng(11)
    figure, axes = new_figure(width=9, height=3)
    axes[0, 0].plot(np.sin(np.arange(50)))
    wave, fall, spread = (
        str(folder / name) for name in ("wave.svg", "fall.svg", "studies/seeds/spread.csv")
    )
    write_figure(wave, figure)
    write_figure(fall, figure)
    write_table(spread, pd.DataFrame({"seed": [1, 2], "ods": [0.8, 0.81]}))
    printed = [str(folder / "as_printed" / name) for name in ("table2.csv", "table3_intervals.csv")]
    for path, table in zip(
        printed, (table2([0.1] * 3, [0.2] * 3), table3_intervals().assign(mean=0.123)), strict=True
    ):
        write_table(path, table)
    scenes = [planted_scene(number, rng) for number in range(4)]
    images = pd.DataFrame(
        product([scene.name for scene in scenes], METHODS), columns=["scene", "method"]
    )
    images = images.assign(psnr=20.0 + images.index, rmse=20.0, ssim=0.4)
    shown = gallery_of(dict.fromkeys(("observed", *METHODS), scenes), images, 4)
    content = page_content(
        gallery={"source": "planted", "scenes": shown, **depth_scale(2.886e-10, 340)},
        images=images,
        tables=sorted(map(str, planted_tables.iterdir())),
        figures=[wave],
        captions={
            wave: ("flight", "A wave (paper, Fig. 6): planted."),
            fall: ("study_seeds", "A fall: from a study."),
        },
        paper=REPORT / "paper.yaml",
        config={
            "seed": 7,
            "source": "reference",
            "phy": {"n_looks": 16},
            "benchmark": {"n_looks": 16},
        },
        note="synthetic reference flight",
        printed=printed,
        studies={"files": {spread: "digest", fall: "digest"}, "parts": ["seeds"]},
        stages={"draw": "labels"},
        benchmarks=folder / "benchmarks",
    )
    write_page(folder / "report.html", REPORT / "page", "page.html.j2", content, FILTERS)
    return folder / "report.html"
