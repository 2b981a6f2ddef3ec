"""Mean power: laws of eq. (1), an independent convolution, the bound of tables on every pixel."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal

from evaluation.lib.atlas_phy import waveform_by_quadrature
from evaluation.lib.literal_phy import largest_error_db, summed_power
from snowsim.echogram import crossing_layers
from snowsim.phy import mean_power
from snowsim.phy.power import TABLE_RANGE, checked_waveforms, echoes_of_parameters

TABLE_LIMIT_DB = 0.05


def scene_of(seed, n_layers, n_range_bins, layout):
    """Layers inside, reaching outside, nearly touching, coincident or on bin centres; some absent.

    Shapes lie in the range of tables, powers vary along track; any unit.
    """
    rng = np.random.default_rng(seed)
    shape = (n_layers, 17)
    reach = 200 if layout == "outside" else 0
    layer_bins = np.sort(rng.uniform(-reach, n_range_bins - 1 + reach / 2, shape), axis=0)
    if layout == "touching":
        layer_bins = layer_bins[:1] + np.cumsum(10 ** rng.uniform(-8, 1, shape), axis=0)
    if layout == "on bins":
        layer_bins = np.rint(layer_bins)
    layer_bins[rng.random(shape) < 0.1] = np.nan
    layer_bins[crossing_layers(layer_bins)] = np.nan
    layer_power = 10 ** rng.uniform(-12, 0, (n_layers, 1)) * (rng.random((n_layers, 1)) < 0.95)
    parameters = {
        "peak_power": layer_power * 10 ** rng.uniform(-2, 0, shape) * 10 ** rng.uniform(-15, 15),
    }
    for name, limits in TABLE_RANGE.items():
        parameters[name] = 10 ** rng.uniform(*np.log10(limits), n_layers)
    return layer_bins, parameters


@settings(max_examples=300, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    n_layers=st.integers(0, 8),
    n_range_bins=st.sampled_from([1, 30, 120]),
    layout=st.sampled_from(["inside", "outside", "touching", "on bins"]),
    noise=st.floats(-8, -2),
)
def test_tables_hold_on_every_pixel(seed, n_layers, n_range_bins, layout, noise):
    layer_bins, parameters = scene_of(seed, n_layers, n_range_bins, layout)
    exact = mean_power(layer_bins, **parameters, n_range_bins=n_range_bins, exact=True)
    fast = mean_power(layer_bins, **parameters, n_range_bins=n_range_bins)
    # A peak between two bins, or in the Gaussian's flank of a layer beside the window, is what no
    # pixel shows: noise is relative to what is there.
    noise_power = 10**noise * exact.max(initial=0)
    assert largest_error_db(fast, exact, noise_power) <= TABLE_LIMIT_DB


@pytest.mark.parametrize("change", [{"layer_bins": [[-3.0]]}, {"peak_power": [1e-30]}])
def test_scenes_that_tables_are_not_meant_for_are_exact(change):
    scene = {"layer_bins": [[30.2]], "peak_power": [1.0], "variance_bins2": [1.0]}
    scene |= {"decay_rate": [0.1], "n_range_bins": 60}
    assert (mean_power(**scene) != mean_power(**scene, exact=True)).any()
    scene |= change
    assert_array_equal(mean_power(**scene), mean_power(**scene, exact=True))


def test_waveform_peaks_at_its_power_on_its_layer_and_as_printed_the_gaussian_does():
    parameters = ([0.3], [12.0], [0.07], 60)
    power = mean_power([[25.0]], *parameters, exact=True)[:, 0]
    assert power.argmax() == 25
    assert_allclose(power[25], 0.3, rtol=1e-14)
    # As printed, the Gaussian is at the layer, and the waveform 4 to 6 bins further down (DESIGN
    # 4.4).
    printed = mean_power([[25.0]], *parameters, exact=True, as_printed=True)[:, 0]
    assert 4 <= printed.argmax() - 25 <= 6
    assert printed.max() > 1


LINES = np.array([[0.0, 0.26, 0.53, 0.77]])  # sub-bin positions
PLAIN = {
    "layer_bins": 100 + LINES,
    "peak_power": [1.0],
    "variance_bins2": [12.0],
    "decay_rate": [0.07],
    "n_range_bins": 256,
}
FAR_APART = {
    "layer_bins": np.concatenate([100 + LINES, 160 + LINES]),
    "peak_power": [1.0, 1e-300],
    "variance_bins2": [12.0, 12.0],
    "decay_rate": [0.07, 0.07],
}
STRONGEST_ABSENT = FAR_APART | {
    "layer_bins": np.concatenate([np.nan * LINES, 160 + LINES]),
    "peak_power": [1e30, 1.0],
}
AT_THE_LIMITS = {
    "all absent": ({"layer_bins": np.nan * LINES}, 1e-3),
    "no range lines": ({"layer_bins": np.empty((1, 0))}, 1e-3),
    "one pixel": ({"layer_bins": [[0.0]], "n_range_bins": 1}, 1e-3),
    "far outside": ({"layer_bins": LINES - 1e4}, 1e-3),
    "no noise": ({}, 0.0),
    "no power": ({"peak_power": [0.0]}, 0.0),
    "power of 1e300": ({"peak_power": [1e300]}, 1e297),
    "300 decades apart": (FAR_APART, 1e-302),
    "strongest absent": (STRONGEST_ABSENT, 1e-3),
}


@pytest.mark.parametrize(("change", "noise_power"), AT_THE_LIMITS.values(), ids=AT_THE_LIMITS)
def test_scenes_at_the_limits_of_valid_input_keep_their_bounds(change, noise_power):
    scene = PLAIN | change
    layers = {name: values for name, values in scene.items() if name != "n_range_bins"}
    echoes = echoes_of_parameters(**layers)
    waveforms = checked_waveforms(echoes, scene["n_range_bins"], as_printed=True)
    expected = summed_power(waveforms, waveform_by_quadrature)
    exact = mean_power(**scene, exact=True, as_printed=True)
    # The waveform to 1e-12, amplitudes and sums to a few more.
    assert largest_error_db(exact, expected, 0.0) <= 1e-11
    fast = mean_power(**scene, as_printed=True)
    largest = expected.max(initial=0)
    assert largest_error_db(fast, expected, max(noise_power, 1e-8 * largest)) <= TABLE_LIMIT_DB


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"peak_power": [-2, 1]}, r"peak_power must be finite, at least 0, got -2 at \(0,\)"),
        ({"peak_power": [4 * [1], [np.nan, 1, 1, 1]]}, r"peak_power must .*, got nan at \(1, 0\)"),
        (
            {"decay_rate": [0.05]},
            r"decay_rate: expected one value for each of 2 layers, got shape \(1,\)",
        ),
        (
            {"layer_bins": [[10.0, 11.0], [20.0, 9.0]]},
            "layer_bins: .* layer 1 does not at range_line 1",
        ),
        ({"n_range_bins": 2.5}, "n_range_bins must be a whole number of at least 1, got 2.5"),
    ],
)
def test_bad_input_is_refused_with_name_value_and_position(change, message):
    with refusal(message):
        mean_power(**(PLAIN | FAR_APART | change))
