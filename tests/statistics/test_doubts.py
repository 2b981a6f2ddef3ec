"""What `fit` says, or refuses, of frames that are not what it takes them for."""

import warnings

import numpy as np
import pytest
import xarray as xr
from flights import frames_of
from refusals import refusal

from snowsim.statistics import fit
from snowsim.statistics.summaries import looks_like_amplitude


@pytest.fixture(scope="module")
def frames():
    drawn = frames_of({"radar": {"n_range_bins": 400}}, 2, 768)
    # Fewer layers are fitted faster.
    return [(echogram, layers.isel(layer=slice(8))) for echogram, layers in drawn]


def test_a_flight_whose_surface_is_missing_is_told_so(frames):
    below = [(echogram, layers.isel(layer=slice(1, None))) for echogram, layers in frames]
    with pytest.warns(UserWarning, match=r"layer 0 lies \d+ range bins .* in 2 of 2 frames"):
        mistaken = fit(below)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        meant = fit(frames)
    assert not [warning for warning in caught if "layer 0" in str(warning.message)]
    # The first year's power for the surface's.
    assert mistaken["peak_power"][0] < 0.5 * meant["peak_power"][0]


@pytest.mark.parametrize("looks", [1, 5, 30])
def test_amplitude_is_told_from_power_at_any_number_of_looks(frames, looks):
    echogram, layers = frames[0]
    speckle = np.random.default_rng(1).standard_gamma(looks, echogram["Data"].shape) / looks
    mean = echogram["Data"].mean("slow_time")
    power = echogram.assign(Data=mean * xr.DataArray(speckle, echogram["Data"].coords))
    assert not looks_like_amplitude(power, layers)
    # Nor is it amplitude where layer 0 is not the surface, whose echo is then no air.
    assert not looks_like_amplitude(power, layers.isel(layer=slice(1, None)))
    amplitude = power.assign(Data=np.sqrt(power["Data"]))
    with refusal("frame 0: Data: expected linear power, found amplitude"):
        fit([(amplitude, layers)])
