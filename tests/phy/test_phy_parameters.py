import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal

from snowsim.phy import draw_parameters


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


def test_a_scene_takes_the_uppermost_layers_and_deeper_ones_look_like_the_last_valid_one(statistics, rng):
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
    assert "speckle_correlation" not in draw_parameters(statistics, 2, speckle_correlation="none", rng=rng)


@pytest.mark.parametrize("width_bounds", [None, [10, 15]])
def test_paper_width_is_uniform_between_the_flight_s_or_given_bounds(statistics, width_bounds, rng):
    if width_bounds is not None:
        statistics["width_bound_bins"] = "bound", [1.0, 2.0]
    drawn = draw_parameters(statistics, 100_000, width="paper", width_bounds=width_bounds, rng=rng)
    variance = drawn["variance_bins2"]
    assert 10 <= variance.min() < variance.max() <= 15
    # Standard errors of mean and deviation of U(10, 15), 1.44 / sqrt(n): allow four.
    assert_allclose([variance.mean(), variance.std()], [12.5, 5 / np.sqrt(12)], atol=4 * 1.44 / np.sqrt(100_000))


@pytest.mark.parametrize(
    ("name", "value", "options", "message"),
    [
        ("peak_power", ("layer", [np.nan, 1, 1]), {}, "peak_power .* at layer 0, got"),
        ("decay_rate", ("layer", [-0.1, 1, 1]), {}, "decay_rate .* at layer 0, got"),
        ("noise_power", 0.0, {}, "noise_power of the statistics must be positive and finite, got 0"),
        ("width_bound_bins", ("bound", [15.0, 10.0]), {"width": "paper"}, "width_bound_bins must .* got 15, 10"),
        ("noise_power", 1e-3, {"width": "paper", "width_bounds": [3, 2]}, "width_bounds must .* got 3, 2"),
        ("noise_power", 1e-3, {"width": "narrow"}, "width must be one of paper, fitted, got 'narrow'"),
        ("noise_power", 1e-3, {"speckle_correlation": "some"}, "speckle_correlation must be one of measured, none"),
        ("noise_power", 1e-3, {"n_layers": 0}, "n_layers must be at least 1, got 0"),
    ],
)
def test_bad_statistics_are_refused(statistics, name, value, options, message, rng):
    statistics[name] = value
    with pytest.raises(ValueError, match=message):
        draw_parameters(statistics, **{"n_layers": 3} | options, rng=rng)
