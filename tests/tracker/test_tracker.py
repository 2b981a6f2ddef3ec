"""Layers planted in an echogram come back, whatever the file has for bins, lines and surface."""

import pickle
from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from planted_layers import BIN_S, NAMES, SURFACE_BIN, planted, ridge_weights, write_weights
from refusals import refusal

from snowsim.alignment import bin_size_s
from snowsim.echogram import check_layers
from snowsim.io import read_echogram
from snowsim.snowpack import Climate, simulate
from snowsim.tracker import canonical, deepest_row
from snowsim.tracking import Tracker

# In the tracker's bins. A ridge 1.3 bins wide peaks within half a bin of where it is planted;
# levelling by whole bins under a mean of 5 lines adds as much.
TOLERANCE_BINS = 1.0
quiet = pytest.mark.filterwarnings("ignore::UserWarning")


def error_bins(found, layers, echogram):
    """Picks less the planted layers, (layer, range_line) in the tracker's bins."""
    assert found.sizes["layer"] == layers.sizes["layer"]
    assert_array_equal(found["slow_time"], echogram["slow_time"])
    return (found["twtt"].values - layers["twtt"].values) / BIN_S


def check_found(tracker, echogram, layers):
    found = tracker.pick(echogram)
    check_layers(found)
    error = error_bins(found, layers, echogram)
    assert np.nanmax(np.abs(error)) < TOLERANCE_BINS
    assert np.isfinite(error).mean() > 0.97  # a line or two at either end of a chain
    return found


def with_looks(echogram, n_looks, rng):
    """The echogram smoothed along track, speckled anew."""
    mean = echogram["Data"].rolling(slow_time=25, center=True, min_periods=1).mean()
    speckle = rng.gamma(n_looks, 1 / n_looks, mean.shape)
    return echogram.assign(Data=(mean * speckle).astype(np.float32))


def ridge_at(echogram, bins):
    """A ridge of unit height at fractional bins by range line."""
    below = np.arange(echogram.sizes["twtt"])[:, None] - bins
    return np.exp(-0.5 * (below / 1.3) ** 2)


def test_layers_planted_in_an_echogram_are_found_and_no_other(tracker, frame):
    found = check_found(tracker, *frame)
    assert found["layer"].values.tolist() == NAMES
    assert found.attrs["notes"] == ""
    picked = np.isfinite(found["twtt"].values)
    assert (found["twtt_low"].values < found["twtt"].values)[picked].all()
    assert (found["twtt_high"].values > found["twtt"].values)[picked].all()
    assert (found["quality"].values[1:][picked[1:]] == 1).mean() > 0.9


@pytest.mark.parametrize(
    ("bin_s", "spacing_m"),
    [(1.6e-10, 5.2), (4.4e-10, 5.2), (BIN_S, 2.6), (1.7e-10, 1.3)],
    ids=["fine bins", "coarse bins", "twice the lines", "fine bins, four times the lines"],
)
def test_other_bins_and_lines_are_undone_on_the_way_out(tracker, rng, bin_s, spacing_m):
    check_found(tracker, *planted(rng, bin_s=bin_s, spacing_m=spacing_m))


def test_without_positions_lines_are_used_as_they_are_and_that_is_said(tracker, frame):
    echogram, layers = frame
    echogram["Latitude"][:] = np.nan
    with pytest.warns(UserWarning, match="no positions: range lines are used as they are"):
        check_found(tracker, echogram, layers)


@pytest.mark.parametrize(
    ("kept", "added_bins", "message"),
    [
        (np.nan, 0, "the file has no surface"),
        (0, 0, "the file has no surface"),
        (0, 40, "surface is wrong on 300 of 300 range lines"),
        (0, 1e9, "surface lies outside the window on 300 of 300 range lines"),
        *((1, off, "the file's surface is wrong on") for off in (-13, -8, -5, 2, 5, 8, 13)),
    ],
)
def test_a_surface_that_is_missing_or_wrong_is_found_and_that_is_said(
    tracker, frame, kept, added_bins, message
):
    echogram, layers = frame
    echogram["Surface"][:] = kept * echogram["Surface"] + added_bins * BIN_S
    with pytest.warns(UserWarning, match=message):
        found = check_found(tracker, echogram, layers)
    assert message in found.attrs["notes"]
    assert found["confidence"].values[0].mean() > 0.8


def test_a_faint_surface_above_a_strong_crust_is_left_where_the_file_has_it(tracker, frame):
    echogram, layers = frame
    surface = layers["twtt"].values[0] / BIN_S
    echogram["Data"] += 2000 * ridge_at(echogram, surface + 10)
    found = tracker.pick(echogram)
    assert found.attrs["notes"] == ""
    assert_allclose(found["twtt"].values[0] / BIN_S, surface, atol=TOLERANCE_BINS)


@quiet
@pytest.mark.parametrize("radar", ["snow-2012", "ku-12-18"])
def test_a_surface_found_has_quality_one_only_where_the_tracker_detects_one(radar):
    tracker = Tracker.from_pretrained()
    echogram, layers = simulate(Climate(accumulation_m=0.3), radar, n_range_lines=512, rng=1)
    echogram["Surface"][:] = np.nan
    found = tracker.pick(echogram)
    off = (found["twtt"].values[0] - layers["twtt"].values[0]) / tracker.card.bin_s
    wrong = np.abs(off - np.median(off)) > 2  # an echo peaks somewhat below its interface
    assert wrong.mean() > 0.02
    good = found["quality"].values[0] == 1
    assert good[wrong].mean() < 0.2
    assert good[~wrong].mean() > 0.95
    assert "no surface is detected" not in found.attrs["notes"]


@quiet
@pytest.mark.parametrize("has_surface", [True, False])
def test_a_frame_upside_down_has_no_pick_of_quality_one_and_a_note_says_why(has_surface):
    tracker = Tracker.from_pretrained()
    echogram, _ = simulate(Climate(accumulation_m=0.4), "snow-2012", n_range_lines=300, rng=7)
    echogram["Data"].values[:] = echogram["Data"].values[::-1]
    if not has_surface:
        echogram["Surface"][:] = np.nan
    found = tracker.pick(echogram)
    assert found["quality"].values[np.isfinite(found["twtt"].values)].min() > 1
    assert "is the frame upside down" in found.attrs["notes"]


@quiet
def test_the_surface_of_a_band_that_the_card_does_not_cover_is_left_and_the_band_is_noted():
    tracker = Tracker.from_pretrained()
    made = simulate(Climate(accumulation_m=0.3), "accumulation", n_range_lines=256, rng=5)
    found = tracker.pick(made[0])
    assert "bin_s 2.4e-09 lies outside the tracker's" in found.attrs["notes"]
    assert "surface is wrong" not in found.attrs["notes"]
    # Within one of the file's bins.
    surface = made[1]["twtt"].values[0]
    assert_allclose(found["twtt"].values[0], surface, atol=float(made[0].attrs["bin_s"]))
    assert found["quality"].values[np.isfinite(found["twtt"].values)].min() > 1


def off_bins(tracker, echogram, surface):
    """Rows, by range line, that the surface used lies below another one [s]."""
    grid = tracker.detect(echogram).canonical.grid
    return grid.surface_row + grid.top - (surface - echogram["twtt"].values[0]) / grid.bin_s


@pytest.mark.parametrize(
    ("n_looks", "n_air_bins", "given"),
    [
        *product((1, 16), (46, 9), (True, False)),
        (1, 1, True),  # too little air to judge a surface
        (1, 0, False),
    ],
)
def test_a_surface_below_bins_that_were_not_recorded_stays_or_is_found(
    tracker, rng, n_looks, n_air_bins, given
):
    echogram = with_looks(planted(rng)[0], n_looks, rng)
    surface = echogram["Surface"].values.copy()
    n_bins, n_lines = echogram["Data"].shape
    # So few bins and 40 more stay recorded above the surface, in turn.
    n_above = n_air_bins + 20 + 20 * np.sin(np.arange(n_lines) / 30)
    recorded = np.arange(n_bins)[:, None] >= surface / bin_size_s(echogram) - n_above
    echogram["Data"] = echogram["Data"].where(recorded)
    if not given:
        echogram["Surface"][:] = np.nan
    off = np.abs(off_bins(tracker, echogram, surface))
    # The next layer lies 40 bins below; without any air a few lines may take it.
    assert (off <= (0 if given else 8)).mean() >= (1 if n_air_bins else 0.99)


def test_a_given_surface_stays_where_a_deeper_interface_is_brighter(tracker, frame):
    echogram, layers = frame
    bright = 1e5 * ridge_at(echogram, layers["twtt"].values[1] / BIN_S)
    echogram["Data"][:, 100:150] += bright[:, 100:150].astype(np.float32)
    assert not off_bins(tracker, echogram, echogram["Surface"].values).any()


def test_a_surface_below_eight_bins_of_air_stays(tracker, frame):
    echogram, layers = frame
    surface = layers["twtt"].values[0]
    first = int((surface.min() - float(echogram["twtt"][0])) / BIN_S) - 8
    off = off_bins(tracker, echogram.isel(twtt=slice(first, None)), surface)
    assert_allclose(off, 0, atol=1e-9)  # rounding


@quiet
def test_most_range_lines_may_be_missing(tracker, frame):
    echogram, layers = frame
    echogram["Data"][:, np.arange(300) % 5 > 1] = np.nan
    found = tracker.pick(echogram)
    # Beside gaps half a bin more.
    assert np.nanquantile(np.abs(error_bins(found, layers, echogram)), 0.99) < TOLERANCE_BINS
    assert np.isfinite(found["twtt"].values[:, 1::5]).mean() > 0.9


@pytest.mark.parametrize(
    ("n_looks", "spacing_m", "averaged", "outside"),
    [(1, 2.6, 4, False), (1, 5.2, 1, True), (16, 5.2, 1, False), (90, 5.2, 1, True)],
)
def test_lines_are_averaged_to_the_looks_that_the_card_knows_or_it_is_said(
    tmp_path, rng, n_looks, spacing_m, averaged, outside
):
    ranges = {"bin_s": [1e-10, 5e-10], "line_spacing_m": [0, 10.5], "n_looks": [3.5, 40]}
    tracker = Tracker.load(write_weights(tmp_path, ridge_weights(), ranges=ranges))
    echogram, _ = planted(rng, spacing_m=spacing_m)
    seen = tracker.detect(with_looks(echogram, n_looks, rng)).canonical
    assert seen.grid.n_averaged == averaged
    assert ("single look" in " ".join(seen.notes)) == (n_looks == 1)
    assert seen.outside == outside
    assert any(note.startswith("n_looks") for note in seen.notes) == outside


def test_an_echogram_outside_the_cards_ranges_is_warned_of_and_no_pick_is_good(tracker, rng):
    echogram, _ = planted(rng, bin_s=7e-10)
    with pytest.warns(UserWarning, match="bin_s 7e-10 lies outside the tracker's 1e-10 to 5e-10"):
        found = tracker.pick(echogram)
    picked = np.isfinite(found["twtt"].values)
    assert picked.sum() > 500
    assert not (found["quality"].values[picked] == 1).any()


def test_there_are_no_picks_below_the_deepest_echo(tmp_path, frame):
    echogram, _ = frame
    # Ridges stand some 10 dB above noise in the mean of 5 rows, the surface over 20 dB.
    for echo_db, n_layers in ((3.0, 5), (15.0, 1)):
        tracker = Tracker.load(write_weights(tmp_path, ridge_weights(), echo_db=echo_db))
        assert tracker.pick(echogram).sizes["layer"] == n_layers


def test_the_deepest_echo_is_a_ridge_along_track_and_no_speck():
    image = np.full((200, 300), 40, dtype=np.uint8)
    image[60:65] = 120
    image[150:153, 100:102] = 255
    deepest = deepest_row(image, 80)
    assert ((deepest > 60) & (deepest < 68)).all()
    assert not deepest_row(image, 240).any()


@quiet
def test_single_look_drone_radar_keeps_its_surface_and_has_no_picks_below_the_ground(shared_data):
    folder = shared_data / "snow_radar" / "uwibass"
    if not (folder / "frame.nc").exists():
        pytest.skip("no frame of UWiBaSS here")
    echogram = read_echogram(folder / "frame.nc")
    tracker = Tracker.from_pretrained()
    surface = echogram["Surface"].values
    assert not off_bins(tracker, echogram, surface).any()
    found = tracker.pick(echogram)
    assert "single look" in found.attrs["notes"]
    bin_s = bin_size_s(echogram)
    seen = np.load(folder / "lines_seen.npz")
    # Rows of `seen` begin elsewhere; surfaces tell where.
    shift = np.nanmedian(seen["surface"] - surface / bin_s)
    rows = found["twtt"].values / bin_s
    assert np.nanmax(rows - (seen["ground"] - shift)) < 20
    picked = np.isfinite(rows)
    assert picked[1:].any()
    assert not (found["quality"].values[picked] == 1).any()


@pytest.mark.parametrize("radar", ["snow-2012", "snow-2-8"])
def test_good_picks_of_simulated_snow_are_right_as_often_as_the_card_says(radar):
    snow = Climate(accumulation_m=0.3)
    echogram, layers = simulate(snow, radar, n_range_lines=400, rng=1)
    tracker = Tracker.from_pretrained()
    found = tracker.pick(echogram)
    assert not found.attrs["notes"]
    away_s = np.abs(layers["peak_twtt"].values[:, None] - found["twtt"].values).min(axis=0)
    good = found["quality"].values == 1
    assert good.sum() > 10 * 400
    # From a confidence of .8 on; on simulated snow nearly all are right.
    assert (away_s[good] < 2 * tracker.card.bin_s).mean() > 0.9


def test_layers_lie_within_the_limits_of_their_picks_neither_always_nor_rarely():
    tracker = Tracker.from_pretrained()
    inside = []
    for seed in (12, 15):
        snow = Climate(accumulation_m=0.3)
        echogram, layers = simulate(snow, "snow-2012", n_range_lines=300, rng=seed)
        found = tracker.pick(echogram).isel(layer=slice(1, None))
        away_s = np.abs(layers["peak_twtt"].values[:, None] - found["twtt"].values).min(axis=0)
        doubtful = (found["confidence"].values > 0.5) & (found["confidence"].values < 0.9)
        doubtful &= away_s < 5 * BIN_S  # else there is no layer
        inside.append(2 * away_s < (found["twtt_high"] - found["twtt_low"]).values)
        inside[-1] = inside[-1][doubtful]
    inside = np.concatenate(inside)
    # Nine of ten by calibration on flights. The 3,600 picks are of some 20 chains, .87 within;
    # half as wide limits hold .60, and twice as wide ones .98.
    assert inside.size > 2000
    assert 0.75 < inside.mean() < 0.97


@pytest.mark.parametrize("n_averaged", [1, 2, 5])
def test_averaged_lines_lie_in_the_middle_of_their_own_lines(tracker, rng, n_averaged):
    echogram, _ = planted(rng, spacing_m=5.2 / n_averaged)
    grid = canonical(echogram, tracker.card).grid
    assert grid.n_averaged == n_averaged
    ramp = 3.0 + 0.25 * np.arange(echogram.sizes["slow_time"])
    back = np.interp(grid.line, np.arange(grid.n_lines), grid.averaged(ramp))
    inside = slice(n_averaged, -n_averaged)  # beyond the middle of the first and last it is level
    assert_allclose(back[inside], ramp[inside], rtol=1e-12)


@pytest.mark.parametrize("rows", [slice(6, 7), slice(-15, None)])
def test_rows_of_a_tiny_number_do_not_change_what_is_found(rows):
    tracker = Tracker.from_pretrained()
    echogram, _ = simulate(Climate(accumulation_m=0.35), "snow-2012", n_range_lines=256, rng=6)
    clean = tracker.pick(echogram)
    for power in (7e-17, 2e-36):
        padded = echogram.copy(deep=True)
        padded["Data"][rows] = power
        found = tracker.pick(padded)
        assert found.sizes == clean.sizes
        # The scale of grey is the same; the network sees the grey of the noise floor there.
        off_bins = np.abs(found["twtt"].values - clean["twtt"].values) / bin_size_s(echogram)
        assert np.nanmean(off_bins < 0.5) > 0.98


def test_probability_lies_on_the_echograms_own_axes(tracker, rng):
    echogram, layers = planted(rng, bin_s=1.9e-10, spacing_m=2.6)
    probability = tracker.annotate(echogram)
    assert probability.dims == ("twtt", "slow_time")
    assert_array_equal(probability["twtt"], echogram["twtt"])
    assert_array_equal(probability["slow_time"], echogram["slow_time"])
    on_layers = probability.sel(twtt=layers["twtt"][1:], method="nearest").values
    assert on_layers.mean() > 0.9
    assert np.nanmean(probability.values) < 0.25  # its convolution says 0.18 where nothing is
    assert np.nanmin(probability.values) >= 0


def test_saturated_lines_do_not_change_what_is_found_beside_them(tracker, frame):
    echogram, layers = frame
    echogram["Data"][:, 100:102] = 1e9
    found = tracker.pick(echogram)
    error = error_bins(found, layers, echogram)
    beside = np.r_[0:90, 112:300]
    assert np.nanmax(np.abs(error[1:, beside])) < TOLERANCE_BINS
    assert np.isfinite(error[1:, beside]).mean() > 0.97


@pytest.mark.parametrize(("brighter_db", "is_saturated"), [(7, False), (14, True)])
def test_lines_ten_decibels_above_the_others_do_not_set_the_scale(
    tracker, frame, brighter_db, is_saturated
):
    echogram, _ = frame
    maximum_db = canonical(echogram, tracker.card).maximum_db
    brightest = float(echogram["Data"].max())  # below, one line of each block is brighter
    echogram["Data"][83, [100, 280]] = brightest * 10 ** (brighter_db / 10)
    grown_db = canonical(echogram, tracker.card).maximum_db - maximum_db
    assert_allclose(grown_db, 0 if is_saturated else brighter_db, atol=0.5)


def test_the_surface_lies_in_row_50_of_the_image_to_half_a_row(tracker, rng):
    # Hills so gentle that the running mean over 15 lines follows them.
    echogram, _ = planted(rng)
    grid = canonical(echogram, tracker.card).grid
    inside = grid.surface_row[20:-20]
    assert_allclose(inside.mean(), 50, atol=0.1)
    assert_allclose(inside, 50, atol=0.75)


def test_flagged_lines_and_fades_of_the_whole_line_have_the_worst_quality(tracker, frame):
    echogram, _ = frame
    flagged = np.zeros(300, dtype=np.uint8)
    flagged[20:30] = 1
    words = {"flag_masks": np.array([1], np.uint8), "flag_meanings": "missing_data"}
    echogram["quality_mask"] = ("slow_time", flagged, words)
    echogram["Data"][:, 200:210] *= 0.01
    found = tracker.pick(echogram)
    quality = np.where(np.isfinite(found["twtt"]), found["quality"], 3)
    assert (quality[:, np.r_[20:30, 200:210]] == 3).all()
    assert (quality[:, 40:190] == 1).mean() > 0.9


@pytest.mark.parametrize(("faded_db", "is_bad"), [(3, False), (9, True)])
def test_picks_of_a_line_that_has_faded_by_six_decibels_are_bad(tracker, frame, faded_db, is_bad):
    echogram, _ = frame
    echogram["Data"][:, 120:130] *= 10 ** (-faded_db / 10)
    quality = tracker.pick(echogram)["quality"].values
    # The largest power of a line of 16 looks scatters by some dB.
    assert (quality[:, 120:130] == 3).all() == is_bad
    assert (quality[:, 120:130] == 3).any() == is_bad
    assert not (quality[:, :110] == 3).any()


@pytest.mark.parametrize(("apart_rows", "is_good"), [(5, False), (8, True)])
def test_layers_hardly_farther_apart_than_chains_may_be_are_not_good(
    tracker, rng, monkeypatch, apart_rows, is_good
):
    bins = SURFACE_BIN + np.array([0, 40, 40 + apart_rows, 120, 180])
    monkeypatch.setattr("planted_layers.LAYER_BINS", bins)
    echogram, _ = planted(rng)
    quality = tracker.pick(echogram)["quality"].values
    assert len(quality) == 5
    # Picks of ridges that touch lie up to a row off, so that not all are nearer than 6 rows.
    good = (quality[1:3] == 1).mean(axis=1)
    assert (good > 0.99).all() if is_good else (good < 0.7).all()
    assert (quality[[0, 3, 4]] == 1).mean() > 0.99


def test_three_lines_give_a_surface_and_nothing_that_crosses(tracker, frame):
    echogram, layers = (each.isel(slow_time=slice(3)) for each in frame)
    found = tracker.pick(echogram)
    check_layers(found)
    assert_allclose(found["twtt"][0], layers["twtt"][0], rtol=0, atol=TOLERANCE_BINS * BIN_S)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda e: e.isel(slow_time=slice(0)), "expected an echogram .*'slow_time': 0"),
        (
            lambda e: e.assign(Data=e["Data"] * 0 + 1),
            "contrast .dB. must be finite, at least 0.001",
        ),
        (lambda e: e.isel(twtt=slice(None, None, -1)), "twtt must increase"),
        (
            lambda e: e.assign_coords(twtt=1e3 * e["twtt"]),
            "twtt: range bins must be finite, at least 9.0.*e-12, at most 9.2.*e-09",
        ),
        (lambda e: e.isel(twtt=slice(20)), "30 range bins or more of measured power must"),
        (lambda e: "frame.nc", "expected an echogram dataset, as snowsim.io.read_echogram"),
        (lambda e: e["Data"], "got {'twtt': 400|got DataArray"),
    ],
    ids=["no line", "constant", "falling time", "milliseconds", "20 bins", "a path", "an array"],
)
def test_an_echogram_that_cannot_be_tracked_is_refused_in_a_line(tracker, frame, change, message):
    with refusal(message):
        tracker.pick(change(frame[0]))


@quiet
def test_missing_pixels_and_lines_are_bridged_or_left_out(tracker, frame):
    echogram, layers = frame
    echogram["Data"][:, 150] = np.nan
    echogram["Data"][:10, 100:] = np.nan
    echogram["Data"][:, 40:90] = np.nan
    found = tracker.pick(echogram)
    error = error_bins(found, layers, echogram)
    assert np.nanmax(np.abs(error[1:])) < TOLERANCE_BINS
    assert np.isfinite(error[1:, 150]).all()  # one line is a certain link
    assert np.isnan(error[:, 45:85]).all()  # fifty are not, yet the layer goes on beyond


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"format": "snowsim tracker 2"}, "expected one of format 'snowsim tracker 1'"),
        ({"bin_s": "long"}, "bin_s must be finite, .* got 'long'"),
        ({"threshold": 1.5}, "threshold must be finite, at least 1e-06, at most 0.999999, got 1.5"),
        ({"ranges": {"bin_s": ["a", "b"]}}, "range of bin_s must be finite, got 'a'"),
        ({"sha256": "0" * 64}, "tracker: expected that of its card"),
    ],
)
def test_a_damaged_card_or_one_of_another_version_is_refused(tmp_path, changes, message):
    path = write_weights(tmp_path, ridge_weights(), **changes)
    with refusal(message) as error:
        Tracker.load(path)
    assert str(error.value).startswith(str(tmp_path))


@pytest.mark.parametrize(
    ("card", "message"),
    [
        ("{", "card of .*: expected JSON"),
        ("[]", r"expected one of format 'snowsim tracker 1', found \[\]"),
        (None, "card of ridges.onnx: expected JSON, found No such file"),
    ],
)
def test_a_card_that_is_no_json_object_or_missing_is_refused(tmp_path, card, message):
    path = write_weights(tmp_path, ridge_weights())
    path.with_suffix(".json").unlink()
    if card is not None:
        path.with_suffix(".json").write_text(card)
    with refusal(message):
        Tracker.load(path)


def test_weights_that_are_no_network_are_refused(tmp_path):
    path = write_weights(tmp_path, b"not a network")
    with refusal("expected an ONNX network"):
        Tracker.load(path)


def test_the_name_of_weights_that_are_not_shipped_is_refused():
    with refusal("that comes with the package must be one of universal, got"):
        Tracker.from_pretrained("nothing")
    for name in ("nothing", "universal"):
        with refusal(f"^{name}: tracker: .* one of: universal"):
            Tracker.load(name)


def test_the_surface_given_counts_where_it_is_sane(tracker, frame):
    echogram, _ = frame
    echogram["Surface"][10:20] += 40 * BIN_S
    found = tracker.pick(echogram)
    bins = found["twtt"].values[0] / BIN_S
    # The swell of 6 bins, and no outlier of 40.
    assert_allclose(bins, SURFACE_BIN, atol=8)


def test_a_frame_has_the_layers_picked_in_it_by_the_names_of_the_segment(tracker, frame, rng):
    echogram, layers = frame
    below = np.arange(echogram.sizes["twtt"]) * BIN_S > layers["twtt"].values[1].max() + 15 * BIN_S
    without = echogram.copy(deep=True)
    without["Data"][below] = 3 * rng.gamma(16, 1 / 16, (below.sum(), 300))
    one, two = tracker.pick_together([tracker.detect(echogram), tracker.detect(without)])
    assert one["layer"].values.tolist() == NAMES
    assert two["layer"].values.tolist() == NAMES[:2]


def test_a_tracker_goes_to_other_processes(tracker, frame):
    again = pickle.loads(pickle.dumps(tracker))
    assert again.pick(frame[0]).identical(tracker.pick(frame[0]))


def test_range_lines_without_power_are_noted(tracker, frame):
    echogram = frame[0].copy(deep=True)
    echogram["Data"][:, :40] = 0
    n_lines = echogram.sizes["slow_time"]
    with pytest.warns(UserWarning, match=f"^40 of {n_lines} range lines hold no power$"):
        tracker.pick(echogram)
