import numpy as np
import pytest
from numpy.testing import assert_allclose
from refusals import refusal
from scipy.stats import ks_2samp

from evaluation.lib.literal_phy import planted_scene, render_as_printed
from snowsim.phy import mean_power, render

N_RANGE_BINS = 200


@pytest.fixture
def planted():
    return planted_scene(6, 64, N_RANGE_BINS, n_looks=20)


@pytest.mark.parametrize("exact", [True, False])
def test_render_draws_what_the_form_as_printed_draws(exact, planted, rng):
    printed = render_as_printed(*planted, N_RANGE_BINS, rng=rng)
    rendered = render(*planted, N_RANGE_BINS, exact=exact, rng=rng)
    layer_bins, parameters = planted
    shapes = [parameters[name] for name in ("peak_power", "variance_bins2", "decay_rate")]
    mean = mean_power(layer_bins, *shapes, N_RANGE_BINS, exact=True) + parameters["noise_power"]
    # 1.95 sqrt(2 / n) = 2.4e-2 once in 1000; the convolution as printed is off by up to 0.08 dB on
    # steep pixels only.
    distance = ks_2samp((printed / mean).ravel(), (rendered / mean).ravel()).statistic
    assert distance < 1.95 * np.sqrt(2 / mean.size)


@pytest.mark.parametrize("exact", [True, False])
def test_speckle_is_that_of_the_parameters(exact, planted):
    layer_bins, parameters = planted
    varied = parameters | {"speckle_correlation": [1, 0.4, 0.1]}
    air = render(layer_bins, varied, N_RANGE_BINS, exact=exact, rng=1)[:20]
    assert air.dtype == (np.float64 if exact else np.float32)
    # 64 lines of 20 bins give a correlation to 0.03.
    neighbours = np.corrcoef(air[:-1].ravel(), air[1:].ravel())[0, 1]
    assert_allclose(neighbours, 0.4, atol=4 * 0.03)


@pytest.mark.parametrize("exact", [True, False])
def test_gain_has_mean_1_and_the_spread_asked_for(exact):
    noise = {"noise_power": 1.0, "n_looks": 1e6, "line_gain_spread_db": 0.5}
    nothing = dict.fromkeys(("peak_power", "variance_bins2", "decay_rate"), [])
    gain = render(np.empty((0, 100_000)), nothing | noise, 1, exact=exact, rng=1)
    assert_allclose(gain.mean(), 1, atol=2e-3)
    assert_allclose((10 * np.log10(gain)).std(), 0.5, rtol=0.01)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"noise_power": np.nan}, "noise_power must be finite, at least 0, got nan"),
        (
            {"peak_power": np.ma.masked_less([1.0, 0.1], 0.5)},
            "power of layers must not be masked, got 1 masked values",
        ),
        ({"gain": 1}, "parameters: expected peak_power, .* got .*gain"),
        ({"n_looks": None}, "parameters: expected peak_power, .*"),
    ],
)
def test_bad_or_missing_parameters_are_refused(change, message, planted, rng):
    layer_bins, parameters = planted
    changed = {name: value for name, value in (parameters | change).items() if value is not None}
    with refusal(message):
        render(layer_bins, changed, N_RANGE_BINS, rng=rng)
