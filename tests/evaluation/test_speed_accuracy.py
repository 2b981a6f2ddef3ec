"""Measures of error, what the charts are of, and the chart itself."""

import numpy as np
import pandas as pd
from numpy.testing import assert_allclose

from evaluation.lib.figures import charts
from evaluation.lib.literal_phy import largest_error_db, planted_scene
from evaluation.lib.speed_accuracy import (
    NODES,
    scene_ways,
    table_error_db,
    waveform_ways,
)
from snowsim.phy.power import NODES_PER_BIN


def test_error_is_that_of_power_plus_noise():
    # Twice the power at a pixel, nothing where both vanish.
    error_db = largest_error_db([3.0, 0.0], [1.0, 0.0], 1.0)
    assert_allclose(error_db, 10 * np.log10(2))
    assert largest_error_db([0.0], [1e-300], 0.0) == 0
    for broken in (np.nan, np.inf, -0.1):
        assert largest_error_db([broken], [0.0], 0.0) == np.inf
    assert largest_error_db([1e-3], [0.0], 0.0) > 1000


def test_default_is_the_table_of_fewest_nodes_within_the_bound():
    errors_db = {nodes: table_error_db(nodes) for nodes in NODES}
    assert min(nodes for nodes in NODES if errors_db[nodes] <= 0.05) == NODES_PER_BIN
    # A parabola's error falls with the square of the distance of nodes.
    assert_allclose(errors_db[8] / errors_db[32], 16, rtol=0.3)


def test_tables_and_the_literal_convolution_near_the_closed_form(rng):
    scene = planted_scene(5, 16, 256)
    errors_db = {(way.method, way.setting): way.error_db for way in waveform_ways(*scene)}
    assert [setting for method, setting in errors_db if method == "table"] == [
        f"{nodes} a bin" for nodes in NODES
    ]
    # Trapezoids: four times as fine, a sixteenth of the error.
    ratio = errors_db["convolution", "1 a bin"] / errors_db["convolution", "4 a bin"]
    assert_allclose(ratio, 16, rtol=0.1)
    ways = {way.method: way for way in scene_ways(*scene, {"width": 8}, rng)}
    assert ways["PHY"].error_db <= 0.05 < ways["PHY, as printed"].error_db
    assert np.isnan(ways["cGAN"].error_db)
    image = ways.pop("cGAN").work()
    assert image.shape == (256, 16)
    for way in ways.values():
        image, *_ = way.work()
        assert image.shape == (256, 16)


def test_points_are_the_fastest_runs_per_pixel_and_what_has_no_error_is_a_line():
    rows = [
        ("mean power", "table", "8 a bin", 0, 1e-6, 0.01, np.nan),
        ("mean power", "table", "8 a bin", 1, 9e-6, 0.01, np.nan),
        ("mean power", "closed form", "every pixel", 0, 5e-6, 0.0, np.nan),
        ("speckle", "quantile", "M = 16", 0, 1e-6, np.nan, 1e-5),
        ("whole scenes", "PHY", "8 nodes a bin", 0, 1e-6, 0.01, np.nan),
        ("whole scenes", "cGAN", "width 16", 0, 7e-6, np.nan, np.nan),
    ]
    columns = ["panel", "method", "setting", "repeat", "seconds", "error_db", "distance"]
    table = pd.DataFrame(rows, columns=columns).assign(n_pixels=100)
    of_waveforms, _, of_scenes = charts.speed_accuracy(table).axes
    points = {line.get_label(): line for line in of_waveforms.get_lines()}
    assert_allclose(points["table"].get_xydata(), [[0.01, 10.0]])
    # Drawn in the band of what is exact, below the least error of the others.
    assert points["closed form"].get_xydata()[0, 0] < 0.01
    others = {line.get_label(): line for line in of_scenes.get_lines()}
    assert_allclose(others["cGAN"].get_ydata(), 70.0)
