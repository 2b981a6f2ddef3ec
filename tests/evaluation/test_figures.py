"""What figures derive from tables and frames; the same figure gives the same bytes."""

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from evaluation.lib.figures.convolution import LEAST_DB, plot_costs, plot_stacks, plot_tails
from evaluation.lib.figures.flight import chosen_bins, chosen_pixels, image_with_gaps
from evaluation.lib.figures.phy import fastest, pareto_front, speed_accuracy_waveforms
from evaluation.lib.figures.style import new_figure, write_figure
from snowsim.echogram import to_uint8


@pytest.mark.parametrize("ending", [".svg", ".png"])
def test_the_same_figure_gives_the_same_bytes(tmp_path, ending):
    paths = [tmp_path / f"{name}{ending}" for name in "xy"]
    for path in paths:
        figure, axes = new_figure()
        axes[0, 0].plot([1, 2], label="line")
        axes[0, 0].legend()
        write_figure(path, figure)
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_a_figure_of_another_kind_is_refused(tmp_path):
    figure, _ = new_figure()
    with pytest.raises(ValueError, match=r"ends in \.svg or \.png"):
        write_figure(tmp_path / "a.jpg", figure)


def test_pareto_front_holds_what_nothing_beats_in_both():
    error = [1.0, 0.5, 0.5, 2.0, float("nan"), 0.0]
    cost = [1.0, 2.0, 3.0, 1.0, 0.1, 9.0]
    assert_array_equal(pareto_front(error, cost), [True, True, False, False, False, True])


def runs():
    return pd.DataFrame(
        {
            "setting": "s",
            "method": ["table", "table", "table", "closed form", "float32 normal"],
            "repeat": [0, 1, 2, 0, 0],
            "seconds": [1e-6, 9e-6, 2e-6, 5e-6, 1e-6],
            "n_pixels": 100,
            "error_db": [0.01, 0.01, 0.01, 0.0, np.nan],
            "device": "cpu",
        }
    )


def test_points_are_the_fastest_runs_per_pixel_and_drawn_with_their_floor_and_front():
    points = fastest(runs(), ("setting", "method")).set_index("method")
    assert points.loc["table", "ns"] == 1e-6 / 100 * 1e9
    assert points.loc["table", "error_db"] == 0.01
    (ax,) = speed_accuracy_waveforms(runs()).axes
    labels = {text.get_text() for text in ax.get_legend().get_texts()}
    assert labels == {"table", "closed form", "Pareto front", "one float32 normal per pixel"}


@pytest.fixture
def table():
    errors = {"Born": (0.1, 1.0), "single scattering": (0.0, 0.2), "convolution": (0.01, 0.3)}
    seconds = [("transfer matrix, stack", 0, 9), ("PHY", 0.05, 0.002), ("PHY", 0.05, 0.001)]
    stacks = pd.DataFrame(errors, index=[1, 10]).melt(
        var_name="method", value_name="error_db", ignore_index=False
    )
    stacks = stacks.reset_index(names="value").assign(part="stacks", sweep="layers", unit="1")
    tails = pd.DataFrame({"value": [10, 20, 10, 20], "error_db": [0.1, 0.2, 0.1, 0.2]})
    tails["reference"] = ["annuli integral", "annuli integral", "SMRT", "SMRT"]
    tails = tails.assign(part="tail", sweep="horizon", unit="dB below the peak", method="PHY")
    scenes = pd.DataFrame(seconds, columns=["method", "error_db", "seconds"])
    return pd.concat([stacks, tails, scenes.assign(part="scene")], ignore_index=True)


@pytest.fixture
def ax():
    return new_figure()[1][0, 0]


def test_stacks_show_every_model_and_nothing_below_the_least(table, ax):
    plot_stacks(ax, table, "layers", "layers")
    lines = {line.get_label(): line.get_ydata() for line in ax.get_lines()}
    assert_allclose(lines["Born"], [0.1, 1.0])
    assert_allclose(lines["single scattering"], [LEAST_DB, 0.2])
    assert_allclose(lines["convolution"], [0.01, 0.3])


def test_tails_of_a_study_join_those_of_the_default_run(table, ax):
    plot_tails(ax, table)
    assert ax.get_legend_handles_labels()[1] == ["horizon, annuli integral", "horizon, SMRT"]


def test_costs_take_the_fastest_repeat(table, ax):
    plot_costs(ax, table)
    points = [np.ravel([line.get_xdata(), line.get_ydata()]) for line in ax.get_lines()]
    assert_allclose(points, [[LEAST_DB, 9], [0.05, 0.001]])


def test_a_frame_without_gaps_looks_as_it_always_did_and_one_of_half_empty_rows_is_refused(rng):
    power = rng.gamma(4, 1e-3, size=(60, 40))
    assert_array_equal(image_with_gaps(power), to_uint8(power)[0])
    with pytest.raises(ValueError, match="half of the range lines"):
        image_with_gaps(np.full((4, 5), np.nan))


def test_ragged_ends_and_gaps_are_black_and_leave_the_rest_as_bright(rng):
    power = rng.gamma(4, 1e-3, size=(60, 400))
    ragged = np.vstack([np.full((20, 400), np.nan), power])
    ragged[20:23, ::3] = np.nan
    ragged[40, 7] = 0
    image = image_with_gaps(ragged)
    missing = np.isnan(ragged) | (ragged == 0)
    assert (image[missing] == 0).all()
    # The noise floor is the smallest of 60 row means; three of them are now of two thirds of their
    # pixels. A mean of 400 pixels of 4 looks, 2.3 dB each, is known to 0.12 dB, a grey level of
    # some 30 dB in 255; allow three.
    without_gaps, *_ = to_uint8(power)
    difference = image[~missing].astype(int) - without_gaps[~missing[20:]]
    assert np.abs(difference).max() <= 3


def test_lines_left_out_are_black_and_leave_the_rest_as_it_was_even_where_they_are_most(rng):
    power = rng.gamma(4, 1e-3, size=(60, 100))
    held = np.arange(100) < 30
    image = image_with_gaps(np.where(held, power, np.nan))
    assert (image[:, ~held] == 0).all()
    # Gaps count as medians of their rows: the floor moves by the scatter of a row of 30 pixels, 2.3
    # / sqrt(30) dB, 6 grey levels of 18 dB in 255.
    alone, *_ = to_uint8(power[:, held])
    assert np.abs(image[:, held].astype(int) - alone).max() <= 6


def test_the_first_four_lines_with_three_layers_are_shown_or_with_as_many_as_there_are():
    layer_bins = np.full((5, 20), np.nan)
    layer_bins[0], layer_bins[2] = 50.0, 90.0
    layer_bins[3, 6:12], layer_bins[4, 2:19] = 110.0, 130.0
    line, layers = chosen_pixels(layer_bins)
    assert line == 2
    assert_array_equal(layers, [0, 2, 4])
    assert chosen_bins(layer_bins[layers, line : line + 4], 800) == (44, 142)
    layer_bins = np.full((3, 20), np.nan)
    assert [np.size(part) for part in chosen_pixels(layer_bins)] == [1, 0]
    assert chosen_bins(np.empty((0, 4)), 800) == (0, 48)
    layer_bins[1, 7:11] = 3.0
    line, layers = chosen_pixels(layer_bins)
    assert (line, list(layers)) == (7, [1])
    assert chosen_bins(layer_bins[layers, line : line + 4], 10) == (0, 10)
