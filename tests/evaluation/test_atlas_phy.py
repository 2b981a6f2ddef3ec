"""The atlas of PHY: compared by sums unlike the closed form; public functions are never wrong."""

import numpy as np
import pytest

from evaluation.lib.atlas_phy import draw_atlas
from snowsim.phy.speckle import METHODS


@pytest.fixture(scope="module")
def atlas():
    return draw_atlas(rng=np.random.default_rng(1))


def test_what_the_package_offers_is_never_wrong_and_the_rest_fails_in_the_atlas(atlas):
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
