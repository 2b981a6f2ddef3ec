import json

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.stats import ks_2samp

from evaluation.lib.literal_phy import planted_scene, render_as_printed
from snowsim.echogram import to_uint8
from snowsim.phy import mean_power, plan, render
from snowsim.phy.texture import draw_gain, draw_texture

N_RANGE_BINS = 200


def planted(n_layers=6, n_lines=64, noise_power=1e-3):
    layer_bins, parameters = planted_scene(n_layers, n_lines, N_RANGE_BINS, n_looks=20)
    return layer_bins, parameters | {"noise_power": noise_power}


def mean_of(layer_bins, parameters, **tolerance):
    shapes = {name: parameters[name] for name in ("peak_power", "variance_bins2", "decay_rate")}
    return mean_power(layer_bins, **shapes, n_range_bins=N_RANGE_BINS, **tolerance)


@pytest.mark.parametrize("tolerance_db", [None, 0.05])
def test_render_is_speckle_about_the_mean_power_and_scales_to_eight_bits_with_a_layer_of_none(
    tolerance_db, rng
):
    layer_bins, parameters = planted()
    parameters["peak_power"][2] = 0
    power = render(layer_bins, parameters, N_RANGE_BINS, tolerance_db=tolerance_db, rng=rng)
    assert to_uint8(power)[0].max() == 255
    speckle = power / (mean_of(layer_bins, parameters) + parameters["noise_power"])
    n_values = speckle.size
    assert power.shape == (N_RANGE_BINS, 64)
    # Four standard errors of mean and variance of n values, and 0.05 dB, 1.2 %, allowed to the
    # mean.
    assert_allclose(
        speckle.mean(), 1, atol=4 / np.sqrt(20 * n_values) + 0.012 * (tolerance_db is not None)
    )
    assert_allclose(speckle.var(), 1 / 20, rtol=4 * np.sqrt(2.3 / n_values) + 0.024)


def test_render_draws_what_the_form_as_printed_draws(rng):
    layer_bins, parameters = planted()
    printed = render_as_printed(layer_bins, parameters, N_RANGE_BINS, rng=rng)
    fast = render(layer_bins, parameters, N_RANGE_BINS, tolerance_db=0.05, rng=rng)
    mean = mean_of(layer_bins, parameters) + parameters["noise_power"]
    # 1.95 sqrt(2 / n) = 2.4e-2 once in 1000; the convolution as printed is off by up to 0.08 dB on
    # steep pixels only.
    assert ks_2samp((printed / mean).ravel(), (fast / mean).ravel()).statistic < 1.95 * np.sqrt(
        2 / mean.size
    )


def test_plan_says_what_it_leaves_out_and_keeps_its_bound():
    layer_bins, parameters = planted(n_layers=12)
    parameters["peak_power"] = 10.0 ** -np.arange(12)
    scene_plan = plan(layer_bins, parameters, N_RANGE_BINS, tolerance_db=0.05)
    notes = json.loads(json.dumps(scene_plan.notes()))
    # Noise of 1e-3 hides to 1 % / 24 of itself what lies below 5e-7: layers 7 to 11.
    assert notes["plan_layers_dropped"] == 5
    assert notes["plan_method"] == "table"
    assert 0 < notes["plan_share"] < 0.5
    assert notes["plan_terms_full"] == 12 * 64 * N_RANGE_BINS
    assert 0 < notes["plan_bound_db"] <= 0.05
    assert notes["plan_cost_normals"] > 0
    # Without noise nothing is left out.
    assert (
        plan(layer_bins, parameters | {"noise_power": 0.0}, N_RANGE_BINS, tolerance_db=0.05).method
        == "exact"
    )


@pytest.mark.parametrize("change", ["tolerance", "noise"])
def test_more_tolerance_or_noise_never_costs_more(change):
    costs = []
    for scale in 10.0 ** np.arange(-6, 0):
        layer_bins, parameters = planted(noise_power=scale if change == "noise" else 1e-3)
        tolerance_db = scale if change == "tolerance" else 0.05
        scene_plan = plan(layer_bins, parameters, N_RANGE_BINS, tolerance_db=tolerance_db)
        costs.append((scene_plan.n_terms, scene_plan.cost_normals))
    assert costs == sorted(costs, reverse=True)


def test_terms_are_counted_as_they_are_computed():
    # A layer of which only the waveform's middle counts: rows with power above zero are the rows in
    # the support.
    layer_bins, parameters = planted(n_layers=1, noise_power=0.5)
    layer_bins[0, 3] = np.nan
    scene_plan = plan(layer_bins, parameters, N_RANGE_BINS, tolerance_db=0.5)
    power = mean_of(layer_bins, parameters, tolerance_db=0.5, noise_power=0.5)
    # Each of 63 lines may count one row more or less at its end.
    assert_allclose(scene_plan.n_terms, np.count_nonzero(power), atol=63)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"noise_power": np.nan}, "noise_power must be finite, at least 0, got nan"),
        ({"gain": 1}, "parameters: expected peak_power, .* got .*gain"),
        *[
            ({name: None}, "parameters: expected peak_power")
            for name in ("peak_power", "noise_power", "n_looks")
        ],
    ],
)
@pytest.mark.parametrize("tolerance_db", [None, 0.05])
def test_bad_or_missing_parameters_are_refused(change, message, tolerance_db, rng):
    layer_bins, parameters = planted()
    changed = {name: value for name, value in (parameters | change).items() if value is not None}
    with pytest.raises(ValueError, match=message):
        render(layer_bins, changed, N_RANGE_BINS, tolerance_db=tolerance_db, rng=rng)


def test_texture_and_gain_have_mean_1_and_the_autocorrelation_asked_for():
    texture = draw_texture(600, 4000, (0.05, 12.0, 3.0), rng=np.random.default_rng(1)).astype(float)
    assert_allclose(texture.mean(), 1, atol=2e-3)  # some 30,000 independent values of s.d. .22
    logarithm = np.log(texture) + np.log1p(0.05) / 2
    for bins, lines in ((0, 0), (12, 0), (0, 1), (0, 3), (24, 2)):
        product = (logarithm[: 600 - bins, : 4000 - lines] * logarithm[bins:, lines:]).mean()
        wanted = np.log1p(0.05) * np.exp(-bins / 12 - (lines / 3) ** 2)
        assert_allclose(product, wanted, atol=0.03 * np.log1p(0.05))
    gain = draw_gain(100_000, 0.5, rng=np.random.default_rng(1))
    assert_allclose(gain.mean(), 1, atol=2e-3)
    assert_allclose((10 * np.log10(gain)).std(), 0.5, rtol=0.01)
