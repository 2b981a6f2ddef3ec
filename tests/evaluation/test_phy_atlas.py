"""The atlas of PHY: compared by sums unlike the closed form; public functions are never wrong."""

import numpy as np
import pandas as pd
import pytest
from eighty_digits import waveform_in_80_digits
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from evaluation.lib.phy_atlas import PLAIN, PUBLIC, draw_atlas, summarise_atlas
from evaluation.lib.phy_cases import quadrature_power, waveform_by_quadrature


@pytest.fixture(scope="module")
def atlas():
    return draw_atlas(rng=np.random.default_rng(1))


@settings(max_examples=150, deadline=None)
@given(
    log_variance=st.floats(-6, 8),
    log_decay=st.floats(-6, 4),
    deviations=st.floats(-30, 300),
    after=st.booleans(),
)
@example(
    log_variance=-6.0, log_decay=4.0, deviations=0.0, after=True
)  # where the integrand starts at its largest
@example(log_variance=8.0, log_decay=-6.0, deviations=0.0, after=False)
def test_quadrature_agrees_with_80_digits(log_variance, log_decay, deviations, after):
    variance = 10**log_variance
    decay = 10**log_decay
    x_bins = deviations * np.sqrt(variance)
    if after:
        x_bins += decay * variance
    expected = waveform_in_80_digits(x_bins, variance, decay)
    if expected < 1e-290:
        return
    # Exponents of up to 700 are known to 3 eps of themselves, 5e-13; the rule itself converges to
    # rounding.
    found = waveform_by_quadrature(np.array([x_bins]), variance, decay)
    assert_allclose(found[0], float(expected), rtol=1e-12)


def test_quadrature_places_layers_on_the_rows_asked_for():
    rows = np.array([3, 90, 200])
    waveforms = PLAIN.waveforms()
    whole = quadrature_power(waveforms, np.arange(PLAIN.n_range_bins))
    # The rule is the same for every pixel.
    assert_allclose(quadrature_power(waveforms, rows), whole[rows], rtol=1e-15)


def test_public_functions_are_never_wrong_and_every_way_to_fail_is_in_the_atlas(atlas):
    public = atlas[atlas["method"].isin(PUBLIC)]
    wrong = public[public["outcome"] == "wrong"]
    assert wrong.empty, wrong.to_string()
    wrong = atlas[atlas["outcome"] == "wrong"].groupby("setting")["method"].agg(set)
    fast_decays = {"naive", "sampled", "wrapped", "cut", "recursive32"}
    assert fast_decays <= wrong["decay rate [per bin]"]
    assert fast_decays | {"nearest"} <= wrong["variance [bins²]"]
    assert "wrapped" in wrong["position [bins]"]
    assert {"sampled", "recursive32", "table32"} <= wrong["power of the weaker layer"]
    assert "table32" in wrong["tolerance [dB]"]
    assert "cut" in wrong["height [bins]"]
    assert wrong["looks M"] == {"cube_open"}


def test_naive_form_fails_where_its_exponential_overflows(atlas):
    regions = summarise_atlas(atlas).set_index(["setting", "method"])
    # exp(a^2 d / 2) overflows at a^2 d = 1420: a = 10.9 for d = 12, sampled every half decade;
    # heads before that.
    assert 3 < regions.loc[("decay rate [per bin]", "naive"), "last_safe"] < 10.9
    assert 1e5 <= regions.loc[("variance [bins²]", "naive"), "last_safe"] < 1420 / 0.07**2


def test_what_must_be_refused_is_refused_and_recursion_drifts_in_single_precision(atlas):
    borders = atlas[atlas["setting"] == "borders"]
    refused = borders.groupby("value")["outcome"].agg(set) == {"refused"}
    assert refused.sum() == 12
    allowed = ["no layers", "all absent", "one pixel", "on top border", "no range lines"]
    assert not refused[allowed].any()
    spacing = atlas[atlas["setting"] == "spacing of two layers [bins]"]
    crossing = spacing[spacing["value"] <= 0]
    assert set(crossing["outcome"]) == {"refused"}
    heights = atlas[atlas["setting"] == "height [bins]"]
    column = heights.pivot_table(index="value", columns="method", values="error_db")
    # exp(-1e-6) in float32 is off by 3e-8 a step: up to 0.13 dB after a million; float64 stays with
    # the plan.
    assert 0.01 < column.loc[1_000_000, "recursive32"] < 0.13
    assert column.loc[1_000_000, "recursive64"] < 1e-4


def test_same_seed_same_atlas(atlas):
    pd.testing.assert_frame_equal(atlas, draw_atlas(rng=np.random.default_rng(1)))


def test_a_method_holds_over_the_longest_run_without_a_wrong_value():
    outcomes = ["wrong", "within", "wrong", "refused", "within", "within", "refused"]
    sweep = pd.DataFrame(
        {"setting": "s", "method": "m", "value": [1.0, 2, 3, 4, 5, 6, 7], "outcome": outcomes}
    )
    region = summarise_atlas(sweep).iloc[0].to_dict()
    expected = {"first_safe": 5, "last_safe": 6, "n_within": 3, "n_refused": 2, "n_wrong": 2}
    assert region == {"setting": "s", "method": "m"} | expected
