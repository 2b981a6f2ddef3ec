"""What `fit` says, or refuses, of frames that are not what it takes them for."""

import warnings

import numpy as np
import pytest
from flights import frames_of
from refusals import refusal

from snowsim import Climate, Radar, simulate
from snowsim.echogram import why_no_power
from snowsim.statistics import fit


def test_a_flight_whose_surface_is_missing_is_told_so():
    frames = frames_of({"radar": {"n_range_bins": 400}}, 2, 768)
    below = [(echogram, layers.isel(layer=slice(1, None))) for echogram, layers in frames]
    with pytest.warns(UserWarning, match=r"layer 0 lies \d+ range bins .* in 2 of 2 frames"):
        fit(below)
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message="layer 0")
        fit(frames)


@pytest.mark.parametrize(
    ("radar", "n_looks", "n_lines"),
    # The presets have little air above the surface.
    [
        ("snow-2-8", 1, 300),
        ("snow-2-8", 5, 300),
        ("ku-12-18", 5, 300),
        ("snow-2012", 5, 300),
        ("snow-2012", 30, 1000),
    ],
)
def test_amplitude_is_told_from_power_of_any_radar_and_number_of_looks(radar, n_looks, n_lines):
    radar = Radar.preset(radar, n_looks=n_looks)
    echogram, layers = simulate(Climate(accumulation_m=0.3), radar, n_range_lines=n_lines, rng=2)
    assert why_no_power(echogram) is None
    amplitude = echogram.assign(Data=np.sqrt(echogram["Data"]))
    with refusal("frame 0: Data looks like amplitude"):
        fit([(amplitude, layers)])
