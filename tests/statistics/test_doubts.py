"""What `fit` says, or refuses, of frames that are not what it takes them for."""

import warnings

import numpy as np
import pytest
import xarray as xr
from flights import frames_of
from refusals import refusal

from snowsim import Climate, simulate
from snowsim.echogram import AMPLITUDE, why_no_power
from snowsim.statistics import fit


@pytest.fixture(scope="module")
def frames():
    drawn = frames_of({"radar": {"n_range_bins": 400}}, 2, 768)
    # Fewer layers are fitted faster.
    return [(echogram, layers.isel(layer=slice(8))) for echogram, layers in drawn]


def test_a_flight_whose_surface_is_missing_is_told_so(frames):
    below = [(echogram, layers.isel(layer=slice(1, None))) for echogram, layers in frames]
    with pytest.warns(UserWarning, match=r"layer 0 lies \d+ range bins .* in 2 of 2 frames"):
        fit(below)
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message="layer 0")
        fit(frames)


@pytest.mark.parametrize("looks", [1, 5, 30])
def test_amplitude_is_told_from_power_at_any_number_of_looks(frames, looks):
    echogram, layers = frames[0]
    speckle = np.random.default_rng(1).standard_gamma(looks, echogram["Data"].shape) / looks
    mean = echogram["Data"].mean("slow_time")
    power = echogram.assign(Data=mean * xr.DataArray(speckle, echogram["Data"].coords))
    assert why_no_power(power) is None
    amplitude = power.assign(Data=np.sqrt(power["Data"]))
    with refusal("frame 0: Data looks like amplitude"):
        fit([(amplitude, layers)])


@pytest.mark.parametrize("radar", ["snow-2-8", "snow-2012", "ku-12-18"])
def test_amplitude_is_told_where_little_air_is_above_the_surface(radar):
    echogram, _ = simulate(Climate(accumulation_m=0.3), radar, n_range_lines=300, rng=2)
    assert why_no_power(echogram) is None
    assert why_no_power(echogram.assign(Data=np.sqrt(echogram["Data"]))) == AMPLITUDE
