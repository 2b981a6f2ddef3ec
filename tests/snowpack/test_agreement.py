"""Agreement of passes over one snow, a function of position, whose differences are planted."""

import itertools

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal

import snowsim
from snowsim import Climate, Radar, Snowpack, Tracker, agreement, simulate
from snowsim.cli import main
from snowsim.constants import EARTH_RADIUS_M, SPEED_OF_LIGHT_M_S
from snowsim.io import open_segments, write_dataset
from snowsim.snowpack import agreement_summary, agreement_table
from snowsim.snowpack.matching import ON, _matched, _Profile
from snowsim.snowpack.meetings import find_places, track_of

DENSITY = 400.0
SPACING_M = 8.0
YEAR_M = 0.3
N_YEARS = 12
ELAPSED = 0.6  # share of a year's snow above the first horizon, in March
CENTRES = {
    "Greenland": (72.0, -40.0),
    "the north pole": (90.0, 0.0),
    "the south pole": (-90.0, 0.0),
    "the antimeridian": (-78.0, 180.0),
}
pytestmark = pytest.mark.filterwarnings("ignore:segment .*snow of:UserWarning")


class Snow:
    """Annual layers as functions of position about a centre: (north, east) on the ground [m]."""

    def __init__(self, seed, n_years=N_YEARS, anomaly_sd=0.15):
        rng = np.random.default_rng(seed)
        self.year_m = YEAR_M * np.exp(anomaly_sd * rng.standard_normal(n_years))
        self.year_m[0] = ELAPSED * YEAR_M
        self.wave = rng.uniform(-1, 1, (2, n_years)) * 2 * np.pi / 3000
        self.phase = rng.uniform(0, 2 * np.pi, n_years)

    def masses(self, north_east_m):
        """Mass of every year's snow (year, range_line) [m w.e.]."""
        angle = self.wave.T @ north_east_m + self.phase[:, None]
        return self.year_m[:, None] * (1 + 0.1 * np.sin(angle))


def line(bearing_deg, length_m=1500.0, aside_m=0.0):
    """Straight track through the centre, or to the right of it, (2, range_line) [m] north, east."""
    along_m = np.arange(-length_m / 2, length_m / 2, SPACING_M)
    bearing = np.radians(bearing_deg)
    ahead = np.array([np.cos(bearing), np.sin(bearing)])
    right = np.array([-np.sin(bearing), np.cos(bearing)])
    return ahead[:, None] * along_m + right[:, None] * aside_m


def degrees(north_east_m, centre):
    """Latitude and longitude of places so far north and east of a centre, along great circles."""
    latitude, longitude = np.radians(centre)
    up = _unit(latitude, longitude)
    north = _unit(latitude + np.pi / 2, longitude)
    east = np.cross(north, up)
    arc = np.linalg.norm(north_east_m, axis=0) / EARTH_RADIUS_M
    ahead = np.stack([north, east]).T @ (north_east_m / EARTH_RADIUS_M)
    x, y, z = np.cos(arc) * up[:, None] + np.sinc(arc / np.pi) * ahead
    return np.degrees(np.arctan2(z, np.hypot(x, y))), np.degrees(np.arctan2(y, x))


def _unit(latitude, longitude):
    return np.array(
        [
            np.cos(latitude) * np.cos(longitude),
            np.cos(latitude) * np.sin(longitude),
            np.sin(latitude),
        ]
    )


def layers_of(mass_m, north_east_m, centre=CENTRES["Greenland"], day="2012-03-30", deeper_m=0.0):
    """Layers under masses (layer, range_line) [m w.e.], planted `deeper_m` too deep."""
    depth_m = 1000 * mass_m / DENSITY + deeper_m
    below_s = 2 * depth_m * (1 + 0.845e-3 * DENSITY) / SPEED_OF_LIGHT_M_S
    twtt = 3e-6 + np.vstack([np.zeros(mass_m.shape[1]), below_s])
    on = ("layer", "slow_time")
    latitude, longitude = degrees(north_east_m, centre)
    confidence = np.where(np.isfinite(twtt), 0.9, np.nan)
    content = {"twtt": (on, twtt, {"units": "s"}), "confidence": (on, confidence)}
    content |= {name: (on, np.ones(twtt.shape, np.uint8)) for name in ("quality", "type")}
    content |= {"Latitude": ("slow_time", latitude), "Longitude": ("slow_time", longitude)}
    times = np.datetime64(day, "ns") + np.arange(twtt.shape[1]) * np.timedelta64(60, "ms")
    names = ["surface", *(f"snow_{n}" for n in range(1, len(twtt)))]
    return xr.Dataset(content, {"layer": names, "slow_time": times})


def passed(snow, north_east_m, **planted):
    """Layers of a pass over snow as it lies."""
    return layers_of(np.cumsum(snow.masses(north_east_m), axis=0), north_east_m, **planted)


def compared(*segments, annual=True, **settings):
    return agreement(segments, DENSITY, annual=annual, **settings)


@pytest.mark.parametrize("angle_deg", [90, 20])
@pytest.mark.parametrize("where", CENTRES)
def test_tracks_that_cross_see_the_same_snow_wherever_it_lies(where, angle_deg):
    snow = Snow(1)
    tracks = [line(30), line(30 + angle_deg)]
    centre = CENTRES[where]
    found = compared(*(passed(snow, track, centre=centre) for track in tracks))
    assert found.sizes["place"] == 1
    (place,) = agreement_table(found).to_dict("records")
    assert place["kind"] == "crossing"
    assert_allclose(place["angle_deg"], angle_deg, atol=1e-3)
    # The nearest lines: each less than a spacing from where the tracks cross.
    assert place["distance_m"] < SPACING_M
    at = track_of(
        xr.Dataset({"Latitude": place["lat"], "Longitude": place["lon"]}).expand_dims("n")
    )
    assert np.linalg.norm(at.vector - _unit(*np.radians(centre))) * EARTH_RADIUS_M < SPACING_M
    # A strip of 50 m about a line: 50 / sin(angle) to either side, to a spacing.
    assert_allclose(place["length_m"], 100 / np.sin(np.radians(angle_deg)), atol=2 * SPACING_M)
    assert place["n_matched"] == N_YEARS
    assert place["share_matched"] == 1
    # Snow changes by a tenth within half a kilometre: in 50 m by less than a hundredth.
    assert place["depth_rms_m"] < 0.03
    assert place["accumulation_rms_m_we"] < 0.003
    assert place["offset_years"] == 0
    assert place["share_same_year"] == 1


def test_a_track_that_runs_back_along_itself_is_compared_with_itself():
    out, back = line(0, 4000.0), line(180, 4000.0, aside_m=-12.0)
    turn = out[:, -1:] + [[6], [6]]
    found = compared(passed(Snow(2), np.hstack([out, turn, back])))
    assert set(found["kind"].values) == {"overlap"}
    assert set(found["meeting"].values) == {0}
    # Four kilometres, but for a quarter before the turn: half a kilometre of track is one pass.
    assert_allclose(found["length_m"], 3775, atol=25)
    assert_allclose(found["angle_deg"], 180, atol=0.1)
    # 12 m aside, and up to half a spacing along track.
    assert ((found["distance_m"] > 11.99) & (found["distance_m"] < np.hypot(12, 4.01))).all()
    assert (found["first"] == found["second"]).all()
    assert (found["days_between"] > 0).all()
    assert (found["share_matched"] == 1).all()
    assert (found["offset_years"] == 0).all()
    assert found["depth_rms_m"].max() < 0.03
    # There is one place in each kilometre and a quarter, in its middle.
    flown = (found["slow_time_first"] - found["slow_time_first"][0]) / np.timedelta64(60, "ms")
    assert_allclose(flown * SPACING_M, [0, 1260, 2520], atol=25)


def test_a_copy_of_a_segment_is_no_other_pass():
    layers = passed(Snow(2), line(0))
    with pytest.warns(
        UserWarning, match="segments 0 and 1: most layers have equal times and depths"
    ):
        compared(layers, layers)


def test_a_loop_crosses_itself_at_its_foot():
    turn = np.linspace(0, 2 * np.pi, 630)
    loop = 800 * np.array([np.sin(turn), 1 - np.cos(turn)])
    before, after = np.split(line(10, 3008.0), 2, axis=1)
    track = track_of(passed(Snow(3), np.hstack([before, loop, after])))
    (place,) = find_places([track], 20.0)
    # The foot of the loop touches the straight track, and lies 1.5 to 6.5 km along it.
    along_m = track.along_m[[place.index_first, place.index_second]]
    assert_allclose(along_m, [1504, 1504 + 1600 * np.pi], atol=160)
    assert place.distance_m < SPACING_M


def test_a_miscounted_year_is_an_offset_of_a_year():
    snow = Snow(4)
    first = passed(snow, line(0))
    without_newest = passed(snow, line(90)).isel(layer=[0, *range(2, N_YEARS + 1)])
    mass_m = np.cumsum(snow.masses(line(90)), axis=0)
    middle_m = (mass_m[:1] + mass_m[1:2]) / 2
    with_crust = layers_of(np.sort(np.vstack([mass_m, middle_m]), axis=0), line(90))
    for second, offset in ((without_newest, 1), (with_crust, -1)):
        found = compared(first, second)
        assert_array_equal(found["offset_years"], [offset])
        assert found["depth_rms_m"] < 0.03  # the layers are the same all the same
        back = compared(second, first)
        assert_array_equal(back["offset_years"], [-offset])
        assert_array_equal(agreement_summary(back)["n_offset"], [1, 1])


def test_a_shift_of_ten_centimetres_is_one_of_depth_and_not_of_years():
    snow = Snow(5)
    found = compared(passed(snow, line(0)), passed(snow, line(90), deeper_m=0.1))
    # Both tracks see other snow by up to a centimetre or two.
    assert_allclose(found["depth_median_m"], 0.1, atol=0.02)
    assert_allclose(found["depth_rms_m"], 0.1, atol=0.02)
    assert_array_equal(found["offset_years"], [0])
    assert_array_equal(found["share_matched"], [1])
    # Of years below the first horizon the shift of both limits cancels.
    assert found["accumulation_rms_m_we"] < 0.003


def test_no_pair_of_twenty_has_an_offset_if_none_is_planted():
    segments = []
    for seed in range(20):
        snow = Snow(100 + seed, n_years=6)
        rng = np.random.default_rng(seed)
        for track in (line(10, 400.0), line(70, 400.0)):
            mass_m = np.cumsum(snow.masses(track), axis=0)
            mass_m += 0.01 * rng.standard_normal(mass_m.shape)
            # A tenth of the picks is missing, in stretches of ten lines.
            gone = np.repeat(rng.random((6, 5)) < 0.1, 10, axis=1)
            segments.append(layers_of(np.where(gone, np.nan, mass_m), track, (60.0 + seed, 5.0)))
    found = compared(*segments, annual=False)
    # Each meets the other one over its own snow alone.
    assert_array_equal(found["first"], [str(2 * pair) for pair in range(20)])
    assert_array_equal(found["second"], [str(2 * pair + 1) for pair in range(20)])
    assert_array_equal(found["offset_years"], np.zeros(20))


def test_snow_that_fell_between_the_flights_is_taken_off_the_later_one():
    snow = Snow(6, anomaly_sd=0)
    track = line(0)
    mass_m = np.cumsum(snow.masses(track), axis=0)
    early = layers_of(mass_m, track)
    # Two years later: two more years of the mean, and the flight at the same time of the year.
    newest = np.array([[ELAPSED], [1 + ELAPSED]]) * YEAR_M * np.ones(track.shape[1])
    late = layers_of(np.vstack([newest, mass_m + 2 * YEAR_M]), track, day="2014-03-30")
    for pair, sign in (((early, late), 1), ((late, early), -1)):
        found = compared(*pair)
        assert_allclose(found["days_between"], sign * 730, atol=1)
        # Years and their means along track are within a tenth of .3 m.
        assert_allclose(found["fallen_m_we"], 0.6, atol=0.03)
        assert_allclose(found["n_matched"], N_YEARS)
        assert_allclose(found["share_matched"], 1)
        assert_array_equal(found["offset_years"], [0] * found.sizes["place"])
        assert (np.abs(found["depth_median_m"]) < 0.08).all()
        # The layers in fallen snow are there, and not counted.
        which = "second" if sign > 0 else "first"
        fallen = found[f"mass_{which}_m_we"] <= 0
        assert fallen.sum() == 2 * found.sizes["place"]
        assert (found["counted"][fallen] == 0).all()


def test_layers_below_the_picks_of_one_track_do_not_count():
    snow = Snow(7)
    deep, shallow = passed(snow, line(0)), passed(snow, line(90))
    shallow = shallow.isel(layer=slice(0, 8))
    found = compared(deep, shallow)
    assert_array_equal([found["n_first"], found["n_second"], found["n_matched"]], [[7]] * 3)
    assert_array_equal(found["share_matched"], [1])
    assert found.sizes["layer"] == N_YEARS
    below = found["layer_second"] == ""
    assert_array_equal(found["counted"], np.where(below, 0, 1))
    assert_array_equal(found["depth_first_m"][~below] > 0, True)
    # A layer that is missing within does.
    holed = compared(deep, shallow.isel(layer=[0, 1, 2, 4, 5, 6, 7]))
    assert_array_equal([holed["n_first"], holed["n_second"], holed["n_matched"]], [[7], [6], [6]])
    assert_allclose(holed["share_matched"], 12 / 13)


def test_a_segment_without_picks_at_the_place_is_met_but_not_compared():
    snow = Snow(8)
    second = passed(snow, line(90))
    second["twtt"][1:, 60:130] = np.nan  # the centre is line 94
    found = compared(passed(snow, line(0)), second)
    assert_array_equal([found["n_first"], found["n_second"]], [[0], [0]])
    assert np.isnan(found["share_matched"]).all()
    assert np.isnan(found["offset_years"]).all()
    (pair, _) = agreement_summary(found).to_dict("records")
    assert (pair["n_crossings"], pair["n_places"], pair["n_compared"]) == (1, 1, 0)


def test_layers_that_are_not_dated_are_matched_all_the_same():
    snow = Snow(12)
    pair = [passed(snow, track).assign_attrs(apart_s=1e-8) for track in (line(0), line(90))]
    with pytest.warns(UserWarning, match="segment [01]: layers: nothing is dated"):
        found = compared(*pair, annual=False)
    assert_array_equal(found["share_matched"], [1])
    assert found.sizes["annual"] == 0
    unknown = ["offset_years", "share_same_year", "accumulation_rms_m_we"]
    assert all(np.isnan(found[name]).all() for name in unknown)
    assert_array_equal(agreement_summary(found)["n_offset"], [0, 0])


def test_places_are_those_of_all_pairs_of_lines(rng):
    """Of wandering tracks, beside a slow search of all pairs of range lines."""
    tracks = []
    for _ in range(4):
        heading = rng.uniform(0, 2 * np.pi) + np.cumsum(0.02 * rng.standard_normal(1200))
        steps = SPACING_M * np.array([np.cos(heading), np.sin(heading)])
        place = np.cumsum(steps, axis=1)
        tracks.append(place - place[:, 600:601] + rng.uniform(-500, 500, (2, 1)))
    tracks = [track_of(layers_of(np.ones((1, 1200)), track)) for track in tracks]
    found = find_places(tracks, 30.0)
    pairs = {(place.first, place.second) for place in found if place.first < place.second}
    for first, second in itertools.combinations(range(4), 2):
        steps = tracks[first].vector[:, None] - tracks[second].vector
        distance_m = EARTH_RADIUS_M * np.linalg.norm(steps, axis=2)
        assert ((first, second) in pairs) == (distance_m.min() <= 30)
        own = [place for place in found if (place.first, place.second) == (first, second)]
        for place in own:
            # Chords are shorter than arcs by 1e-12 of these lengths.
            at = (place.index_first, place.index_second)
            assert_allclose(place.distance_m, distance_m[at], rtol=1e-9)
        # Every line that is near the other track belongs to a meeting: it lies within its length.
        near = tracks[first].along_m[(distance_m <= 30).any(axis=1)]
        ends = [(tracks[first].along_m[p.index_first], p.length_m) for p in own]
        assert all(any(abs(m - middle) <= length for middle, length in ends) for m in near)
        if own and not any(place.is_overlap for place in own):
            assert_allclose(min(p.distance_m for p in own), distance_m.min(), rtol=1e-9)
    assert len(found) > 2


def test_layers_are_assigned_one_to_one_with_the_least_squares(rng):
    """Beside a slow search of all assignments of four layers and three."""
    for _ in range(20):
        sides = [np.sort(rng.uniform(0.1, 1, size)) for size in (4, 3)]
        first, second = (
            _Profile(np.array([*"abcd"][: m.size]), np.nan * m, m, m, pd.Series(dtype=float))
            for m in sides
        )
        tolerance_m = 0.15
        counted = [m <= min(sides[0][-1], sides[1][-1]) + tolerance_m for m in sides]
        away = np.abs(sides[0][:, None] - sides[1]) / tolerance_m
        away[~(counted[0][:, None] & counted[1])] = 1
        away = np.minimum(away, 1)
        least = min(
            sum(away[layer, other] ** 2 for other, layer in enumerate(layers))
            for layers in itertools.permutations(range(4), 3)
        )
        table = _matched(first, second, tolerance_m)
        off = ((table["mass_first_m_we"] - table["mass_second_m_we"]).dropna()) / tolerance_m
        assert_allclose((off**2).sum() + 3 - off.size, least)
        matched = table[(table["layer_first"] != "") & (table["layer_second"] != "")]
        assert matched["layer_first"].is_monotonic_increasing
        assert matched["layer_second"].is_monotonic_increasing
        assert len(table) == 7 - off.size


RADARS = (
    Radar.preset("snow-2012", line_spacing_m=SPACING_M, n_looks=16),
    Radar.preset("snow-2-8", line_spacing_m=SPACING_M, n_looks=16, height_m=900.0),
)


def agreement_of_radars(tracker, seed):
    """Agreement of tracked layers where two radars cross over one snow, and both miscounts.

    The simulator flies over a snow of range lines, wherever they lie: here on either track. A
    miscount is the most frequent error of the years of a pass, by the true layers.
    """
    n_lines, n_years = 256, 14
    rng = np.random.default_rng(seed)
    drawn = Climate(accumulation_m=0.45, n_years=n_years).draw(1, SPACING_M, rng=rng)
    snow = Snow(seed, n_years)
    tracks = (line(0, 2048.0), line(70, 2048.0))
    picked, true_m = [], []
    for track, radar in zip(tracks, RADARS, strict=True):
        along = snow.masses(track) / snow.year_m[:, None]
        thickness_m = np.diff(drawn.depth_m, axis=0) * along
        depth_m = np.vstack([np.zeros(n_lines), np.cumsum(thickness_m, axis=0)])
        seen = Snowpack(depth_m, drawn.density_kg_m3, coherent=False)
        echogram, truth = simulate(seen, radar, rng=rng)
        echogram["Latitude"][:], echogram["Longitude"][:] = degrees(track, CENTRES["Greenland"])
        positions = echogram[["Latitude", "Longitude", "Elevation"]]
        picked.append(tracker.pick(echogram).assign(positions))
        true_m.append(truth["depth_m"].values[:, n_lines // 2])
    found = agreement(picked, temperature_k=243, expected_m=0.45, expected_error=0.1)
    layers = found[list(ON["layer"])].to_dataframe()
    miscounts = []
    for which, horizon_m in zip(("first", "second"), true_m, strict=True):
        own = layers.dropna(subset=[f"depth_{which}_m", f"year_{which}"])
        away_m = np.abs(horizon_m[:, None] - own[f"depth_{which}_m"].to_numpy())
        # A flight at the end of August 2000: the first horizon is that of 1999.
        true_year = 2000 - away_m.argmin(axis=0)
        miscounts.append(float((own[f"year_{which}"] - true_year).mode()[0]))
    return found, miscounts


def test_two_radars_and_speckles_over_one_snow_agree_by_their_tracked_layers():
    found, miscounts = agreement_of_radars(Tracker.from_pretrained(), 4)
    assert found["n_matched"] >= 9
    assert found["share_matched"] > 0.8
    # Bins of both are 3 and 1 cm of snow; medians over 13 lines err by less than one.
    assert found["depth_rms_m"] < 0.03
    assert miscounts == [0, 0]
    assert_array_equal(found["offset_years"], [0])


@pytest.mark.slow
def test_an_offset_is_the_difference_of_the_miscounts_of_both_passes():
    tracker = Tracker.from_pretrained()
    for seed in range(20):
        found, (first, second) = agreement_of_radars(tracker, seed)
        assert_array_equal(found["offset_years"], [second - first])
        assert found["share_matched"] > 0.8
        assert found["depth_rms_m"] < 0.03


def test_what_cannot_be_compared_is_refused_or_left_out():
    snow = Snow(10)
    here, there = passed(snow, line(0)), passed(snow, line(90))
    far = passed(snow, line(90) + [[0], [2000]])
    with refusal("expected tracks that meet within 50 m.*none among 2 segments: within_m widens"):
        compared(here, far)
    with refusal("none among 0 segments"):
        agreement([])
    with refusal("none among 1 segments"):
        agreement(here, DENSITY)  # its track might meet itself
    with refusal("segment 1: expected range lines at most within_m, 50 m, apart.*found 64 m"):
        compared(here, there.isel(slow_time=slice(None, None, 8)))
    with refusal("segment there: Latitude and Longitude: expected those of range lines, found no"):
        agreement({"here": here, "there": there.drop_vars("Latitude")}, DENSITY)
    with refusal("segment 0: Latitude and Longitude: .* all are missing"):
        compared(here.assign(Latitude=np.nan * here["Latitude"]), there)
    with refusal("within_m must be"):
        compared(here, there, within_m=0)
    with refusal("tolerance_years must be finite, above 0, at most 0.5, got 0.6"):
        compared(here, there, tolerance_years=0.6)
    bare = there.isel(layer=[0])
    with refusal("segment 0 is left out: density"):
        agreement([here, there], 1.0)
    with refusal("segment 1 is left out: layers: expected the surface"):
        compared(here, bare)
    with pytest.warns(UserWarning, match="segment 2 is left out: layers: expected the surface"):
        found = compared(here, there, bare)
    assert_array_equal(found["first"].values, ["0"])
    assert_array_equal(found["second"].values, ["1"])


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with layer files of two segments that cross, one of them in two frames."""
    monkeypatch.chdir(tmp_path)
    snow = Snow(11)
    first = passed(snow, line(0))
    write_dataset("20120330_04_001_layers.nc", first.isel(slow_time=slice(0, 90)))
    write_dataset("20120330_04_002_layers.nc", first.isel(slow_time=slice(90, None)))
    write_dataset("other_layers.nc", passed(snow, line(90), deeper_m=0.1))
    return ["20120330_04_001_layers.nc", "20120330_04_002_layers.nc", "other_layers.nc"]


def test_the_command_writes_table_summary_and_picture(place, capsys):
    main(["agreement", *place, "-o", "a.csv", "--density", "400", "--png"])
    printed = capsys.readouterr().out
    assert "a.csv: 1 crossings and 0 overlaps of 1 pairs of segments, 1 of 1 places" in printed
    assert f"1.00 of {2 * N_YEARS} layers are matched\ndepth differs by 0.1 m" in printed
    assert "years are offset at 0 places, 1.00 of matched and dated layers have" in printed
    (row,) = pd.read_csv("a.csv").to_dict("records")
    assert (row["first"], row["second"]) == ("20120330_04", "other")
    assert_allclose(row["depth_median_m"], 0.1, atol=0.02)
    pair, whole = pd.read_csv("a_summary.csv").to_dict("records")
    assert (pair["first"], whole["first"]) == ("20120330_04", "all")
    assert pair["n_matched"] == whole["n_matched"] == N_YEARS
    with open("a.png", "rb") as file:
        assert file.read(4) == b"\x89PNG"


def test_the_netcdf_has_every_layer_with_units_and_meaning(place, capsys):
    main(["agreement", *place, "-o", "a.nc", "--density", "400", "--within-m", "80"])
    found = xr.load_dataset("a.nc")
    assert found.attrs["within_m"] == 80
    for on, content in ON.items():
        for name, (units, meaning) in content.items():
            assert found[name].dims == (on,)
            assert found[name].attrs["long_name"] == meaning
            assert found[name].attrs.get("units") == units
    assert found.sizes["layer"] == N_YEARS
    with pytest.raises(SystemExit):
        main(["agreement", *place, "-o", "a.nc"])
    assert "a.nc: the file is there, --force writes over it" in capsys.readouterr().err


def test_two_files_of_one_name_without_a_segment_are_refused(place, tmp_path):
    again = tmp_path / "again/other_layers.nc"
    with refusal("again/other_layers.nc: name: expected another name than that of other_layers.nc"):
        open_segments([*place, again])


def test_the_name_for_scripts_is_that_of_the_package():
    assert snowsim.agreement is agreement
