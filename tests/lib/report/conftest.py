"""A report of planted tables, figures and scenes: seconds instead of a run of the workflow."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import write_report

from lib.figures.style import new_figure, write_figure
from lib.report.gallery import layer_lines
from lib.report.page import image_uri, write_json
from snowsim.io.files import write_table

ROOT = Path(__file__).resolve().parents[2]
SETS = ("rd", "rd_gd", "rd_pd", "rd_pd_gd")
OUTPUTS = (*(f"side_{side}" for side in range(1, 6)), "fuse")


def planted_scene(number, rng):
    """A scene of the gallery: layers that grow in number, noise that darkens with depth."""
    n_bins, n_lines, n_layers = 300 + 200 * number, 256, 3 * number
    waves = 4 * np.sin(np.arange(n_lines) / 20)
    layers = 50 + waves + 12.0 * np.arange(n_layers + 1)[:, None]
    layers[-1, 100:140] = np.nan
    fade = np.linspace(230, 60, n_bins)[:, None]
    images = {
        name: image_uri(np.clip(fade + rng.normal(0, 12, (n_bins, n_lines)), 0, 255).astype(np.uint8))
        for name in ("observed", "cgan", "phy")
    }
    scores = {method: {"ssim": 0.4, "psnr": 21.5, "rmse": 20.0} for method in ("cgan", "phy")}
    return {
        "name": f"test_{number:04d}",
        "n_range_bins": n_bins,
        "n_range_lines": n_lines,
        "n_layers": n_layers,
        "layers": layer_lines(layers),
        "images": images,
        "scores": scores,
    }


def planted_intervals():
    rows = [
        (output, training_set, metric, 0.8, 0.78, 0.82, 0.01 * k, 0.01 * k - 0.005, 0.01 * k + 0.005, 2, 60)
        for output in OUTPUTS
        for k, training_set in enumerate(SETS)
        for metric in ("ods", "ois", "ap")
    ]
    names = ["output", "training_set", "metric", "mean", "low", "high", "difference", "difference_low"]
    return pd.DataFrame(rows, columns=[*names, "difference_high", "n_replicas", "n_images"])


@pytest.fixture(scope="session")
def planted_tables(tmp_path_factory):
    """Folder of the tables that a report cannot do without."""
    folder = tmp_path_factory.mktemp("tables")
    table2 = [
        {"metric": metric, "statistic": statistic, "cgan": 0.4, "phy": 0.5}
        for metric in ("ssim", "psnr", "rmse")
        for statistic in ("min", "mean", "max")
    ]
    write_table(folder / "table2.csv", pd.DataFrame(table2))
    write_table(folder / "table3_intervals.csv", planted_intervals())
    long_names = {f"a_column_with_quite_a_long_name_{k}": np.arange(30) / 7 for k in range(12)}
    write_table(folder / "wide.csv", pd.DataFrame(long_names))
    return folder


@pytest.fixture(scope="session")
def planted_page(planted_tables, tmp_path_factory):
    """A report of planted tables, written by the workflow's own script."""
    folder = tmp_path_factory.mktemp("page")
    rng = np.random.default_rng(11)
    figure, axes = new_figure(width=9, height=3)
    axes[0, 0].plot(np.sin(np.arange(50)))
    write_figure(folder / "wave.svg", figure)
    (folder / "wave.rst").write_text("A wave (paper, Fig. 6): planted.\n")
    write_json(
        folder / "gallery.json",
        {"source": "planted", "bin_size_s": 2.886e-10, "scenes": [planted_scene(number, rng) for number in range(4)]},
    )
    study = folder / "studies/seeds/spread.csv"
    write_table(study, pd.DataFrame({"seed": [1, 2], "ods": [0.8, 0.81]}))
    (folder / "fall.rst").write_text("A fall: from a study.\n")
    write_figure(folder / "fall.svg", figure)
    figure = {"file": str(folder / "fall.svg"), "caption": str(folder / "fall.rst")}
    images = [{"scene": f"s{i}", "method": m, "psnr": 20.0 + i, "rmse": 20.0, "ssim": 0.4}
              for i in range(3) for m in ("cgan", "phy")]  # fmt: skip
    write_table(folder / "similarity.parquet", pd.DataFrame(images))
    inputs = SimpleNamespace(
        tables=sorted(map(str, planted_tables.iterdir())),
        images=folder / "similarity.parquet",
        gallery=folder / "gallery.json",
        paper=ROOT / "workflow/report/paper.yaml",
        page=sorted((ROOT / "workflow/report/page").iterdir()),
    )
    write_report.write_report(
        inputs,
        folder / "report.html",
        config={"seed": 7, "source": "reference", "phy": {"align": "peak"}},
        note="synthetic reference flight",
        figures=[{"file": str(folder / "wave.svg"), "caption": str(folder / "wave.rst"), "stage": "charts"}],
        studies={"files": {str(study): "digest"}, "figures": [{**figure, "stage": "study_seeds"}], "parts": ["seeds"]},
        stages={"draw": "labels"},
        benchmarks=folder / "benchmarks",
    )
    return folder / "report.html"
