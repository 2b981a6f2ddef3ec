"""The tiny configuration through every rule."""

import numpy as np
import pandas as pd
from runs import run_snakemake, text_of

from snowsim.echogram import crossing_layers
from snowsim.io.scenes import SceneSet


def test_both_tables_are_complete(tiny_run):
    table2 = pd.read_csv(tiny_run / "results/tables/table2.csv")
    assert list(table2.columns) == ["metric", "statistic", "cgan", "phy"]
    assert len(table2) == 9
    table3 = pd.read_csv(tiny_run / "results/tables/table3.csv")
    assert list(table3["output"]) == ["side_1", "side_2", "side_3", "side_4", "side_5", "fuse"]
    assert list(table3.columns) == [
        "output",
        *[f"{s}_{m}" for s in ("rd", "rd_gd", "rd_pd", "rd_pd_gd") for m in ("ods", "ois", "ap")],
    ]
    scores = table3.drop(columns="output").to_numpy()
    assert np.isfinite(scores).all()
    assert ((scores >= 0) & (scores <= 1)).all()


def test_every_label_set_is_rendered_by_both_methods_at_its_own_height(tiny_run):
    sets = {
        name: sorted((tiny_run / "results" / name).glob("*.nc")) for name in ("labels", "phy/labels", "cgan/labels")
    }
    labels, phy, cgan = (SceneSet(paths) for paths in sets.values())
    assert len(labels) == len(phy) == len(cgan) > 0
    for label, by_phy, by_cgan in zip(labels, phy, cgan, strict=True):
        assert label.name == by_phy.name == by_cgan.name
        assert by_phy.image.shape == by_cgan.image.shape == (label.n_range_bins, label.n_range_lines)
        assert 5 <= label.layer_bins.shape[0] - 1 <= 40
        assert not crossing_layers(label.layer_bins).any()


def test_a_second_run_has_nothing_to_do(tiny_run):
    assert "Nothing to be done" in text_of(run_snakemake(tiny_run, "--dry-run"))


def test_nothing_half_written_is_left(tiny_run):
    assert [str(path) for path in (tiny_run / "results").rglob("*.part*")] == []


def test_every_figure_decodes(tiny_run):
    figures = sorted((tiny_run / "results/figures").iterdir())
    assert figures
    for path in figures:
        if path.suffix == ".png":
            from PIL import Image

            with Image.open(path) as image:
                assert np.asarray(image).std() > 0
        else:
            from xml.etree import ElementTree

            assert ElementTree.parse(path).getroot().tag.endswith("svg")
