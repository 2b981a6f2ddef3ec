import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal

from snowsim.echogram import Scene
from snowsim.phy import draw_parameters, mean_power, scene_parameters


@pytest.fixture
def statistics():
    return xr.Dataset(
        {
            "peak_power": ("layer", [1.0, 0.3, 0.2]),
            "decay_rate": ("layer", [0.09, 0.07, np.nan]),
            "variance_bins2": ("layer", [11.0, 12.0, 13.0]),
            "width_bound_bins": ("bound", [10.0, 15.0]),
            "noise_power": 1e-3,
        },
        attrs={"n_looks": 100.0},
    )


def test_a_scene_takes_the_uppermost_layers_and_deeper_ones_look_like_the_last_valid_one(
    statistics, rng
):
    parameters = draw_parameters(statistics, 5, width="fitted", n_looks=None, rng=rng)
    assert_array_equal(parameters["peak_power"], [1, 0.3, 0.2, 0.2, 0.2])
    assert_array_equal(parameters["decay_rate"], [0.09, 0.07, 0.07, 0.07, 0.07])
    assert_array_equal(parameters["variance_bins2"], [11, 12, 13, 13, 13])
    assert parameters["noise_power"] == 1e-3
    assert parameters["n_looks"] == 100
    # A shallow scene takes the uppermost layers; looks may be given.
    parameters = draw_parameters(statistics, 2, n_looks=16, rng=rng)
    assert_array_equal(parameters["peak_power"], [1, 0.3])
    assert parameters["n_looks"] == 16


def test_speckle_is_correlated_as_measured_unless_none_is_asked_for_or_known(statistics, rng):
    assert "speckle_correlation" not in draw_parameters(statistics, 2, rng=rng)
    statistics["speckle_correlation"] = ("speckle_lag", [1.0, 0.1])
    assert_array_equal(draw_parameters(statistics, 2, rng=rng)["speckle_correlation"], [1, 0.1])
    assert "speckle_correlation" not in draw_parameters(
        statistics, 2, speckle_correlation="none", rng=rng
    )


def test_the_background_lies_below_the_surface_and_adds_its_own_power(statistics, rng):
    layer_bins = np.array([[50.0] * 8, [50.5] * 4 + [np.nan] * 4, [90.0] * 8])
    scene = Scene(name="planted", n_range_bins=300, layer_bins=layer_bins)
    without = scene_parameters(scene, statistics, rng=rng)  # statistics made before it was measured
    statistics["background_power"], statistics["fall"] = (
        ("fall", [0.01, 0.0, 0.002]),
        ("fall", [30.0, 100.0, 1000.0]),
    )
    rows, parameters = scene_parameters(scene, statistics, rng=rng)
    assert rows.shape == (5, 8)
    assert (np.diff(rows[:4, :4], axis=0) > 0).all()
    names = ("peak_power", "variance_bins2", "decay_rate")
    shapes = [[given[name] for name in names] for given in (without[1], parameters)]
    added = mean_power(rows, *shapes[1], 300) - mean_power(layer_bins, *shapes[0], 300)
    # From 90 bins below the surface on the exponentials alone. Each has its power at its peak, up
    # to 5 bins below the row's Gaussian of 11 bins^2: up to exp(5 / 30) more than the law.
    depth = np.arange(140, 300) - 50.0
    law = 0.01 * np.exp(-depth / 30) + 0.002 * np.exp(-depth / 1000)
    assert_allclose(added[140:], np.tile(law[:, None], 8), rtol=0.25)
    printed, _ = scene_parameters(scene, statistics, background="none", rng=rng)
    assert_array_equal(printed, layer_bins)
    with pytest.raises(ValueError, match="background must be one of measured, none, got 'some'"):
        scene_parameters(scene, statistics, background="some", rng=rng)


@pytest.mark.parametrize("width_bounds", [None, [10, 15]])
def test_paper_width_is_uniform_between_the_flight_s_or_given_bounds(statistics, width_bounds, rng):
    if width_bounds is not None:
        statistics["width_bound_bins"] = "bound", [1.0, 2.0]
    drawn = draw_parameters(statistics, 100_000, width="paper", width_bounds=width_bounds, rng=rng)
    variance = drawn["variance_bins2"]
    assert 10 <= variance.min() < variance.max() <= 15
    # Standard errors of mean and deviation of U(10, 15), 1.44 / sqrt(n): allow four.
    assert_allclose(
        [variance.mean(), variance.std()], [12.5, 5 / np.sqrt(12)], atol=4 * 1.44 / np.sqrt(100_000)
    )


@pytest.mark.parametrize(
    ("name", "value", "options", "message"),
    [
        ("peak_power", ("layer", [np.nan, 1, 1]), {}, "peak_power .* at layer 0, got"),
        ("decay_rate", ("layer", [-0.1, 1, 1]), {}, "decay_rate .* at layer 0, got"),
        (
            "noise_power",
            0.0,
            {},
            "noise_power of the statistics must be positive and finite, got 0",
        ),
        (
            "width_bound_bins",
            ("bound", [15.0, 10.0]),
            {"width": "paper"},
            "width_bound_bins must .* got 15, 10",
        ),
        (
            "noise_power",
            1e-3,
            {"width": "paper", "width_bounds": [3, 2]},
            "width_bounds must .* got 3, 2",
        ),
        (
            "noise_power",
            1e-3,
            {"width": "narrow"},
            "width must be one of paper, fitted, got 'narrow'",
        ),
        (
            "noise_power",
            1e-3,
            {"speckle_correlation": "some"},
            "speckle_correlation must be one of measured, none",
        ),
        ("noise_power", 1e-3, {"n_layers": 0}, "n_layers must be at least 1, got 0"),
    ],
)
def test_bad_statistics_are_refused(statistics, name, value, options, message, rng):
    statistics[name] = value
    with pytest.raises(ValueError, match=message):
        draw_parameters(statistics, **{"n_layers": 3} | options, rng=rng)
