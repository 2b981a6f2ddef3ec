"""Gaps, short flights, odd input: degraded by a stated rule or refused in one line, never a NaN."""

import warnings

import numpy as np
import pytest
import xarray as xr
from made_up import made_up_frame
from numpy.testing import assert_allclose, assert_array_equal
from planted import Alike
from refusals import refusal

from evaluation.lib.atlas_statistics import is_finite
from snowsim import statistics
from snowsim.io import read_dataset, write_dataset


@pytest.fixture(scope="module", params=statistics.ESTIMATORS)
def estimator(request):
    return request.param


@pytest.fixture(scope="module")
def whole(flight, estimator):
    return statistics.fit(flight, estimator=estimator)


def fit_finite(frames, estimator="deblended"):
    fitted = statistics.fit(frames, estimator=estimator)
    assert is_finite(fitted)
    return fitted


def with_gaps(frame, gaps):
    """Frame with picks of (layer, first line, last line) removed."""
    echogram, layers = frame
    layers = layers.copy(deep=True)
    for layer, first, last in gaps:
        layers["twtt"].values[layer, first:last] = np.nan
    return echogram, layers


def test_order_and_partition_of_frames_do_not_matter(flight, whole, estimator):
    frames = [statistics.summarise(*frame) for frame in flight]
    parts = [statistics.merge([frames[i] for i in part]) for part in ((3, 0), (2,), (1,))]
    other = statistics.estimate(statistics.merge(parts), estimator=estimator)
    for name in whole.variables:
        assert_allclose(other[name], whole[name], rtol=1e-10)
    assert other.attrs == whole.attrs


def test_frames_of_other_line_spacings_are_warned_of(flight):
    one, other = (statistics.summarise(*frame) for frame in flight[:2])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        statistics.merge([one, other.assign(line_spacing_m=1.05 * one["line_spacing_m"])])
    wide = other.assign(line_spacing_m=10 * one["line_spacing_m"])
    with pytest.warns(UserWarning, match="lines of frames lie .* to .* m apart: statistics along"):
        statistics.merge([one, wide])


def test_a_frame_that_is_there_twice_is_refused(flight):
    one, other, third = (statistics.summarise(*frame) for frame in flight[:3])
    with refusal("frames of a flight must differ, got 1 that are there twice"):
        statistics.merge([one, other, third, other])


def test_zeros_within_range_lines_are_warned_of_where_they_are_many(flight, rng):
    echogram, layers = flight[0]
    place = rng.random(echogram["Data"].shape)
    with pytest.warns(UserWarning, match="frame: Data is 0 on [12].[0-9] % of .* was subtracted"):
        statistics.summarise(echogram.assign(Data=echogram["Data"].where(place > 0.02, 0)), layers)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        statistics.summarise(echogram.assign(Data=echogram["Data"].where(place > 1e-3, 0)), layers)


def test_travel_times_in_nanoseconds_are_refused(flight):
    echogram, layers = flight[0]
    in_ns = echogram.assign_coords(twtt=1e9 * echogram["twtt"])
    with refusal(r"range bin of twtt \[s\] must be .* at most 1e-06, got"):
        statistics.summarise(in_ns, layers.assign(twtt=1e9 * layers["twtt"]))


def test_a_summary_survives_the_disk(flight, tmp_path):
    summary = statistics.summarise(*with_gaps(flight[1], [(4, 0, 256)]))
    write_dataset(tmp_path / "summary.nc", summary)
    back = read_dataset(tmp_path / "summary.nc")
    for name, values in summary.variables.items():
        assert_array_equal(back[name], values, err_msg=name)
        assert back[name].dtype == values.dtype
    with refusal("content must be .* 6', got 'none': summarise its frames"):
        statistics.merge([back.assign_attrs(content="none")])


def test_range_lines_of_zeros_are_missing_lines(flight):
    echogram, layers = flight[0]
    kept = ~np.isin(np.arange(256), np.arange(40, 60))
    zeros, missing = (
        echogram.assign(Data=echogram["Data"].where(kept, empty)) for empty in (0.0, np.nan)
    )
    found = statistics.summarise(zeros, layers)
    expected = statistics.summarise(*with_gaps((missing, layers), [(slice(None), 40, 60)]))
    assert found["n_outside"] == 20 * 5
    xr.testing.assert_equal(found.drop_vars("n_outside"), expected.drop_vars("n_outside"))
    fit_finite([(zeros, layers), *flight[1:]])  # a group of lines without a layer


def test_gaps_are_no_zeros(flight, whole, estimator):
    gaps = [(1, 30, 60), (2, 0, 120), (3, 100, 256), (4, 60, 256), (0, 10, 15)]
    fitted = fit_finite([*flight[:3], with_gaps(flight[3], gaps)], estimator)
    # An eighth of the picks is missing: what is left moves by its sampling error, 1 to 2 %.
    assert_allclose(fitted["peak_power"], whole["peak_power"], rtol=0.05)
    assert_allclose(fitted["decay_rate"], whole["decay_rate"], rtol=0.06)
    assert_array_equal(fitted["n_picks"], whole["n_picks"] - [5, 30, 120, 156, 196])


def test_layers_in_too_few_lines_are_left_out_and_counted(flight, estimator):
    fitted = fit_finite(
        [with_gaps(frame, [(4, 20 * (i == 0), 256)]) for i, frame in enumerate(flight)], estimator
    )
    assert fitted.sizes["layer"] == 4
    assert fitted.attrs["n_layers_seen"] == 5


def test_picks_outside_the_record_become_gaps_and_are_counted(flight):
    echogram, layers = flight[0]
    cut = echogram.isel(twtt=slice(0, 180))
    fitted = fit_finite([(cut, layers), *flight[1:]])
    rows = (layers["twtt"].values - echogram["twtt"].values[0]) / 2.886e-10
    assert fitted.attrs["n_picks_outside"] == (rows >= 179.5).sum() > 0


def test_a_frame_without_surface_adds_nothing(flight):
    fitted = statistics.fit([*flight[:3], with_gaps(flight[3], [(0, 0, 256)])])
    without = statistics.fit(flight[:3])
    assert fitted.attrs["n_frames_without_surface"] == 1
    assert_allclose(fitted["decay_rate"], without["decay_rate"], rtol=1e-12)
    assert_allclose(fitted["noise_power"], without["noise_power"], rtol=1e-12)


def test_level_layers_without_speckle_are_one_zone_and_have_the_most_looks(estimator):
    planted = Alike()
    fitted = fit_finite([made_up_frame(*planted.level(), minute=i) for i in range(5)], estimator)
    # Travel times pass through datasets and depths through float32: 1e-4 bins.
    assert_allclose(fitted["thickness_mean_bins"], 44, atol=1e-3)
    assert fitted.attrs["n_looks"] > 1e5
    if estimator == "deblended":
        # The fit ends when steps fall below 1e-3.
        assert_allclose(fitted["decay_rate"], planted.decay_rate, rtol=2e-3)


def test_what_cannot_be_fitted_is_refused(planted, flight):
    echogram, layers = flight[0]
    with refusal("air 30 range bins above the surface must .* at least 1"):
        statistics.fit([(echogram.isel(twtt=slice(30, None)), layers)])
    later = layers.assign_coords(slow_time=layers["slow_time"] + np.timedelta64(1, "h"))
    with refusal("slow_time is not that of the echogram: range line"):
        statistics.fit([(echogram, later)])
    with refusal("frames of a flight must .* at least 1, got 0"):
        statistics.fit([])
    with refusal("surface picked in 1 frames must .* of at least 5, got 0"):
        statistics.fit([with_gaps(flight[0], [(slice(None), 0, 256)])])
    with refusal("zones need slab 0"):
        statistics.fit([(part.isel(slow_time=slice(0, 255)) for part in flight[0])])
    with refusal("estimator must be one of deblended, paper, got 'best'"):
        statistics.fit(flight, estimator="best")
    other = made_up_frame(*planted.level(), minute=9, bin_s=1.17e-10)
    with refusal("share one bin size, got 2.886e-10 s and, at 2012-01-01T00:09.*, 1.17e-10 s"):
        statistics.fit([*flight, other])


def test_a_year_no_one_picked_lies_between_its_neighbours(planted, flight, estimator):
    fitted = fit_finite([with_gaps(frame, [(2, 0, 256)]) for frame in flight], estimator)
    assert fitted.sizes["layer"] == 5
    assert fitted["substituted"].values[2] == 1
    above, bridged, below = fitted["peak_power"].values[1:4]
    assert_allclose(bridged, np.sqrt(above * below), rtol=2**-15)
    # The layer is there, unpicked: its neighbours must not take it for their own. Powers take up
    # what the shared decay rate leaves: 3 and 6 %.
    if estimator == "deblended":
        assert_allclose([above, below], planted.peak_power[[1, 3]], rtol=0.08)


def test_zones_without_data_take_what_the_others_have(flight, estimator):
    summary = statistics.merge(statistics.summarise(*frame) for frame in flight)
    fitted = statistics.estimate(summary, estimator=estimator, zone_edge_bins=[10, 20, 30, 35, 90])
    assert is_finite(fitted)
    assert_array_equal(fitted["n_samples"], [[0] * 4] * 3 + [[4] * 4])
    # Shares of the first slab are those of all zones; absolute thickness is theirs times the middle
    # of the zone.
    relative = fitted["relative_thickness_mean"]
    assert_allclose(relative[:3], relative.values[[3, 3, 3]])
    ratio = fitted["thickness_mean_bins"][:3] / relative[:3]
    assert_allclose(ratio, np.repeat([[15.0], [25], [32.5]], 4, axis=1), rtol=2**-16)


def test_fit_warns_of_what_stands_on_too_little_and_says_on_how_much(flight):
    with pytest.warns(UserWarning, match="zones stands on") as warned:
        fitted = statistics.fit(list(flight)[:1])
    said = " | ".join(str(warning.message) for warning in warned)
    assert "zones stands on 1 blocks, 16 are needed" in said
    assert fitted["common_spread_db"] == 0
    for name in fitted.attrs["radiometry_missing"].split(", "):
        assert f"{name} is held constant: 1 frames and 1 blocks" in said
