"""What `fit` says of frames that are not what it takes them for."""

import warnings

import pytest
from flights import frames_of

from snowsim.statistics import fit


def test_a_flight_whose_surface_is_missing_is_told_so():
    frames = frames_of({"radar": {"n_range_bins": 400}}, 2, 768)
    below = [(echogram, layers.isel(layer=slice(1, None))) for echogram, layers in frames]
    with pytest.warns(UserWarning, match=r"layer 0 lies \d+ range bins .* in 2 of 2 frames"):
        fit(below)
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message="layer 0")
        fit(frames)
