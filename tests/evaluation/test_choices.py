"""Parts of the scene model: left out of the statistics, and the loss without them."""

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

from evaluation.lib.choices import PARTS, WHOLE, choice_table, without
from snowsim.echogram import Kind
from snowsim.front import REFERENCE
from snowsim.io.files import read_dataset
from snowsim.labels import draw_scene, prepare


@pytest.fixture(scope="module")
def flight():
    return read_dataset(REFERENCE)


def drawn(flight, part, seed=3):
    """A scene drawn from statistics that lack a part."""
    model = prepare(without(flight, part), 256)
    return draw_scene(model, 256, name="", rng=np.random.default_rng(seed))


def test_the_whole_model_lacks_nothing(flight):
    assert without(flight, WHOLE) is flight


@pytest.fixture(scope="module")
def whole(flight):
    return drawn(flight, WHOLE)


@pytest.mark.parametrize("part", [part for part in PARTS if part != "relief"])
def test_layers_stay_where_they_are_below_the_surface(flight, whole, part):
    less = drawn(flight, part)
    depth = less.layer_bins - less.layer_bins[0]
    assert_allclose(depth, whole.layer_bins - whole.layer_bins[0], atol=1e-9)
    assert less.echoes.power.shape == whole.echoes.power.shape


def test_layers_without_relief_are_level(flight):
    less = drawn(flight, "relief")
    assert_allclose(np.ptp(less.layer_bins - less.layer_bins[0], axis=1), 0, atol=1e-3)


def test_the_surface_and_echoes_below_are_left_out(flight, whole):
    assert np.ptp(drawn(flight, "surface_row").layer_bins[0]) == 0 < np.ptp(whole.layer_bins[0])
    less = drawn(flight, "echoes_below").echoes
    assert not less.power[less.kind == Kind.BELOW].any()
    assert whole.echoes.power[less.kind == Kind.BELOW].all()


def test_gain_and_correlation_are_left_out(flight):
    assert drawn(flight, "line_gain").echoes.line_gain_spread_db == 0
    assert drawn(flight, "speckle_correlation").echoes.speckle_correlation is None


def test_background_is_that_of_the_flight(flight):
    less = drawn(flight, "background").echoes
    of_flight = flight["background_power"].values
    assert_allclose(less.power[less.kind == Kind.BACKGROUND][:, 0], of_flight[of_flight > 0])


def test_layers_without_variation_have_the_power_of_the_flight(flight, whole):
    is_layer = whole.echoes.kind == Kind.LAYER
    alike = drawn(flight, "power").echoes.power[is_layer].mean(axis=1)
    of_flight = flight["peak_power"].values[: alike.size]
    assert np.std(np.log(alike[1:] / of_flight[1:])) < 0.3
    varied = whole.echoes.power[is_layer].mean(axis=1)
    assert np.std(np.log(varied[1:] / of_flight[1:])) > 0.5


def test_losses_are_paired_by_flight_and_training():
    rows = []
    for flight, level in ((1101, 0.8), (1102, 0.7)):
        for replica, shift in enumerate((0.0, 0.01, 0.02)):
            rows += [
                (flight, WHOLE, replica, level + shift, 0.6),
                (flight, "power", replica, level + shift - 0.03, level),
                (flight, "background", replica, level + shift - 0.001, 0.6),
            ]
    columns = ["flight", "training_set", "replica", "ods", "told_apart"]
    scores = pd.DataFrame(rows, columns=columns)
    table = choice_table(scores).set_index("part")
    assert list(table.index) == ["power", "background"]
    assert_allclose(table[["mean", "low", "high"]].T, [[0.03, 0.001]] * 3)
    assert list(table["costs_little"]) == [False, True]
    assert_allclose(table["told_apart"], [0.75, 0.6])
    assert_allclose(table["whole_told_apart"], 0.6)
    assert_allclose(table.loc["power", ["flight_1101", "flight_1102"]].astype(float), 0.03)
