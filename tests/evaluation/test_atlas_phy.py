"""The atlas of PHY: compared by sums unlike the closed form; public functions are never wrong."""

import numpy as np
import pandas as pd
import pytest
from eighty_digits import waveform_in_80_digits
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from evaluation.lib.atlas_phy import draw_atlas, waveform_by_quadrature
from snowsim.phy.speckle import METHODS


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


def test_what_the_package_offers_is_never_wrong_and_the_rest_fails_in_the_atlas(atlas):
    assert list(atlas.groupby("sweep").size() > 0) == [True] * 4
    wrong = atlas[atlas["outcome"] == "wrong"]
    offered = wrong[wrong["method"].isin(["exact", "table", *METHODS])]
    assert offered.empty, offered.to_string()
    failing = wrong.groupby("sweep")["method"].agg(set)
    assert failing["decay rate [per bin]"] == {"naive closed form", "convolution"}
    assert failing["variance [bins²]"] == {"naive closed form", "convolution"}
    assert failing["power of the weaker layer [dB]"] == {"convolution"}


def test_looks_that_a_method_cannot_draw_are_refused(atlas):
    refused = atlas[atlas["outcome"] == "refused"].groupby("method")["value"].agg(list)
    assert refused.to_dict() == {"gamma": [0.5], "looks": [0.5, 1.5], "quantile": [0.5, 1e7, 1e9]}


def test_same_seed_same_atlas(atlas):
    pd.testing.assert_frame_equal(atlas, draw_atlas(rng=np.random.default_rng(1)))
