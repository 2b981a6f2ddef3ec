"""Measures of error, what the charts are of, and the chart itself."""

from contextlib import nullcontext, suppress

import numpy as np
from numpy.testing import assert_allclose

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


def test_tables_and_the_literal_convolution_near_the_closed_form():
    scene = planted_scene(5, 16, 256)
    errors_db = {(way.method, way.setting): way.error_db for way in waveform_ways(*scene)}
    # Trapezoids: four times as fine, a sixteenth of the error.
    ratio = errors_db["convolution", "1 a bin"] / errors_db["convolution", "4 a bin"]
    assert_allclose(ratio, 16, rtol=0.1)
    rng = np.random.default_rng(1)
    ways = {way.method: way for way in scene_ways(*scene, {"width": 8}, rng)}
    assert ways["PHY"].error_db <= 0.05 < ways["PHY, as printed"].error_db
    assert np.isnan(ways["cGAN"].error_db)
    for way in ways.values():
        # The generator is untrained: its pixels may overflow, after all of its work.
        with suppress(FloatingPointError) if way.method == "cGAN" else nullcontext():
            way.work()
