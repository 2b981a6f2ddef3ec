"""Depth, age and accumulation of layers whose snow is known: drawn, or that of real cores."""

import functools
import warnings
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal

from snowsim.cli import main
from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.io import Profile, open_segment, write_dataset
from snowsim.io.layers import write_layer_files
from snowsim.snowpack import Climate, accumulation, by_year, pieces, simulate, table
from snowsim.snowpack.dating import Series, posterior
from snowsim.snowpack.firn import depth_herron_langway80, temperature_fausto09, travel_time_s
from snowsim.snowpack.horizons import median_series
from snowsim.tracker.layers import layers_of_frame
from snowsim.tracker.linking import Piece

N_LINES = 400
DENSITY = 400.0
ERROR_S = 2e-10
pytestmark = pytest.mark.filterwarnings("ignore:layers. snow of:UserWarning")


def layers_of(below_s):
    """Layers at travel times below the surface (layer, range_line) [s], the surface above them."""
    n_lines = below_s.shape[1]
    twtt = 3e-6 + np.vstack([np.zeros(n_lines), below_s])
    on = ("layer", "slow_time")
    variables = {"twtt": twtt, "twtt_low": twtt - ERROR_S, "twtt_high": twtt + ERROR_S}
    variables |= {"confidence": np.where(np.isfinite(twtt), 0.9, np.nan)}
    content = {name: (on, values) for name, values in variables.items()}
    content |= {name: (on, np.ones(twtt.shape, np.uint8)) for name in ("quality", "type")}
    latitude = 70 + 5e-5 * np.arange(n_lines)
    content |= {"Latitude": ("slow_time", latitude), "Longitude": ("slow_time", 0 * latitude)}
    content |= {"Elevation": ("slow_time", 0 * latitude)}
    times = np.datetime64("2012-03-30", "ns") + np.arange(n_lines) * np.timedelta64(40, "ms")
    names = ["surface", *(f"snow_{n}" for n in range(1, len(twtt)))]
    return xr.Dataset(content, {"layer": names, "slow_time": times})


def below_s(water_m, density=DENSITY):
    """Travel time [s] under a mass of snow [m w.e.] of one density."""
    depth_m = 1000 * np.asarray(water_m) / density
    return 2 * depth_m * (1 + 0.845e-3 * density) / SPEED_OF_LIGHT_M_S


@pytest.fixture
def year_m(rng):
    """Mass of years (year, range_line) [m w.e.]: .3 on average, .15 above the first horizon."""
    anomaly = np.exp(0.15 * rng.standard_normal((10, 1)))
    along = 1 + 0.05 * np.sin(np.arange(N_LINES) / 60)
    return np.vstack([0.15 * along[None], 0.3 * anomaly * along])


def water_of(year_m):
    return np.cumsum(year_m, axis=0)


def test_every_year_has_the_mass_between_its_horizons(year_m):
    water_m = water_of(year_m)
    found = accumulation(layers_of(below_s(water_m)), DENSITY, year=2011)
    assert_array_equal(found["year"], 2011 - np.arange(10))
    # Conversions are exact but for rounding of travel times of some 3 us, 4e-22 s.
    assert_allclose(found["accumulation_m_we"], year_m[1:], rtol=1e-9)
    assert_allclose(found["depth_m"], 1000 * water_m[:-1] / DENSITY, rtol=1e-9)
    assert_allclose(found["thickness_m"], 1000 * year_m[1:] / DENSITY, rtol=1e-9)
    assert_allclose(found["open_m_we"], year_m[0], rtol=1e-9)
    assert_array_equal(found["layer_year"], [np.nan, *(2011 - np.arange(11))])
    # A picture of the layers goes as far.
    assert_allclose(found["depth_at"][-1], 1.1 * 1000 * water_m.max() / DENSITY, rtol=1e-9)
    # Of errors of two picks and of density over the refractive index, for nine of ten: 5 % of the
    # profile, and 30 kg m-3 of each year's snow.
    picks = np.sqrt(2) * ERROR_S / below_s(year_m[1:])
    half = np.hypot(picks, 1.645 * np.hypot(0.05, 30 / DENSITY) / (1 + 0.845e-3 * DENSITY))
    assert_allclose(found["high"] / found["accumulation_m_we"] - 1, half, rtol=1e-6)
    assert_allclose(1 - found["low"] / found["accumulation_m_we"], half, rtol=1e-6)


def test_a_horizon_that_is_missed_makes_one_span_of_two_years(year_m):
    times = below_s(water_of(year_m))
    times[4, 100:] = np.nan
    found = accumulation(layers_of(times), DENSITY, year=2011)
    assert_array_equal(found["n_years"][:, 250], [1, 1, 1, 2, 2, 1, 1, 1, 1, 1])
    span = found.isel(year=[3, 4], slow_time=slice(200, 300))
    mean_m = year_m[4:6, 200:300].mean(axis=0)
    assert_allclose(span["accumulation_m_we"], [mean_m, mean_m], rtol=1e-9)
    depth_m = 1000 * water_of(year_m) / DENSITY
    middle_m = (depth_m[3] + depth_m[5]) / 2
    assert_allclose(span["depth_m"][1], middle_m[200:300], rtol=1e-9)
    # It is nowhere picked: two years about their mean scatter by .2 to .25, over 2^.5, beside the
    # errors of picks and of density.
    times[4] = np.nan
    span = accumulation(layers_of(times), DENSITY, year=2011).isel(year=[3, 4])
    mean_m = year_m[4:6].mean(axis=0)
    picks = np.sqrt(2) * ERROR_S / below_s(2 * mean_m)
    density = np.hypot(0.05, 30 / DENSITY / np.sqrt(2)) / (1 + 0.845e-3 * DENSITY)
    least, most = (
        np.hypot(picks, 1.645 * np.hypot(density, of_year / np.sqrt(2))) for of_year in (0.2, 0.25)
    )
    half = (span["high"] / mean_m - 1).values
    assert (least < half).all()
    assert (half < most).all()


def test_a_pick_between_two_horizons_is_left_out_or_flagged(year_m):
    times = below_s(water_of(year_m))
    between = np.full(N_LINES, np.nan)
    between[150:250] = (0.75 * times[3] + 0.25 * times[4])[150:250]
    found = accumulation(layers_of(np.insert(times, 4, between, 0)), DENSITY, year=2011)
    away = np.r_[0:150, 250:N_LINES]
    assert_allclose(found["accumulation_m_we"][:, away], year_m[1:, away], rtol=1e-9)
    same = np.isclose(found["accumulation_m_we"], year_m[1:], rtol=1e-9)
    assert (same | (found["flag"] > 0)).all()


def test_a_frame_that_a_person_corrected_counts_beside_those_of_the_tracker(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    for name in ("confidence", "twtt_low", "twtt_high"):
        layers[name][:, 200:] = np.nan
    found = accumulation(layers, DENSITY, year=2011)
    assert_allclose(found["accumulation_m_we"], year_m[1:], rtol=1e-9)
    assert (found["high"] > found["low"]).all()


def test_a_faint_layer_in_the_tail_of_the_surface_is_left_out_and_said_to_be(year_m):
    tail = below_s(np.full((1, N_LINES), 0.06))
    layers = layers_of(np.vstack([tail, below_s(water_of(year_m))]))
    layers["confidence"][1] = np.where(np.arange(N_LINES) < 100, 0.6, 0.3)
    with pytest.warns(UserWarning, match="faint snow_1 left out above snow_2, .*that of 2011 "):
        found = accumulation(layers, DENSITY, year=2011)
    assert found.attrs["uppermost"] == "snow_2=2011"
    assert_allclose(found["accumulation_m_we"], year_m[1:], rtol=1e-9)


@pytest.mark.parametrize("first_m", [0.06, 0.3])
@pytest.mark.parametrize("annual", [True, False])
def test_the_first_layer_has_the_year_however_thin_the_snow_above_it(year_m, first_m, annual):
    year_m[0] = first_m
    layers = layers_of(below_s(water_of(year_m)))
    found = accumulation(layers, DENSITY, year=2011, annual=annual)
    assert found.attrs["uppermost"] == "snow_1=2011"
    assert_allclose(found["accumulation_m_we"].sel(year=2011), year_m[1], rtol=1e-9)


def test_a_first_horizon_that_may_be_missing_is_said_and_makes_ages_uncertain(year_m):
    year_m[0] = 0.3
    layers = layers_of(below_s(water_of(year_m)[2:]))
    with pytest.warns(UserWarning, match="snow of .* typical years lies above snow_1"):
        found = accumulation(layers, DENSITY)
    # Two horizons are missing above the first layer: nine of ten ages hold them.
    assert (found["year_confidence"] < 0.8).all()
    assert (found["flag"] == 1).all()
    first = found.isel(year=0)
    assert (first["age_low"] <= 2).all()
    assert (first["age_high"] >= 2).all()
    named = accumulation(layers, DENSITY, year={"snow_1": 2009}).sel(year=2009)
    assert (named["year_confidence"] == 1).all()
    assert (named["age_low"] == named["age_high"]).all()


@pytest.mark.parametrize(
    ("flown", "latitude", "newest"),
    [
        ("2012-03-30", 70, 2011),
        ("2011-08-30", 70, 2010),
        ("2011-09-02", 70, 2011),
        ("2012-02-27", -70, 2011),
        ("2012-03-02", -70, 2012),
        ("2011-11-10", 70, 2011),
        ("2011-11-10", -70, 2011),
        ("2012-01-10", -70, 2011),
    ],
)
def test_without_a_year_the_newest_horizon_is_of_the_last_autumn(year_m, flown, latitude, newest):
    layers = layers_of(below_s(water_of(year_m))).assign(Latitude=("slow_time", [latitude] * 400))
    layers["slow_time"] = layers["slow_time"] + (np.datetime64(flown) - np.datetime64("2012-03-30"))
    for annual in (True, False):
        found = accumulation(layers, DENSITY, annual=annual)
        assert_array_equal(found["year"], newest - np.arange(10))
        assert_allclose(found["accumulation_m_we"], year_m[1:], rtol=1e-9)


def test_without_a_year_horizons_above_the_first_layer_are_counted(year_m):
    times = below_s(water_of(year_m)[1:])
    times[0, 200:] = np.nan
    layers = layers_of(times)
    found = accumulation(layers, DENSITY)
    assert found.attrs["uppermost"] == "snow_1=2010"
    assert_array_equal(found["year"], 2010 - np.arange(9))
    assert_allclose(found["accumulation_m_we"][0, :200], year_m[2, :200], rtol=1e-9)
    assert_allclose(found["accumulation_m_we"][1:], year_m[3:], rtol=1e-9)


def test_a_doubtful_count_makes_all_below_it_doubtful_to_the_next_named_layer():
    water_m = water_of(np.full((16, N_LINES), 0.3))
    regular = accumulation(layers_of(below_s(water_m)), DENSITY, year=2011)
    assert (regular["year_confidence"] > 0.95).all()
    water_m[5:] += 0.3 * 0.6  # one year or two
    layers = layers_of(below_s(water_m))
    found = accumulation(layers, DENSITY, year=2011)
    sure = found["year_confidence"].isel(slow_time=0).values
    assert (np.diff(sure) <= 0).all()
    assert (sure[:5] > 0.9).all()
    assert (sure[5:] < 0.8).all()
    # The doubtful year itself, too: its lower end is unsure.
    assert_array_equal(found["flag"].isel(slow_time=0), np.arange(15) >= 4)
    # The year is 1 or 2: limits hold both, where nothing else is doubtful.
    year_m = found["accumulation_m_we"][4]
    assert (found["low"][4] < 0.55 * year_m).all()
    assert (found["age_high"] - found["age_low"] >= 1)[5:].all()
    named = accumulation(layers, DENSITY, year={"snow_1": 2011, "snow_10": 2002})
    sure = named["year_confidence"].isel(slow_time=0).values
    # Doubt is least at both names, and rises towards the doubtful year between them.
    assert sure[9] == 1
    assert (sure[:12] > 0.9).all()


def test_where_every_layer_is_one_year_thickness_alone_is_suspicious(year_m):
    layers = layers_of(below_s(water_of(year_m))).drop_vars("confidence")
    assert (accumulation(layers, DENSITY)["flag"] == 0).all()
    year_m[4] = 0.66
    layers = layers_of(below_s(water_of(year_m))).drop_vars("confidence")
    found = accumulation(layers, DENSITY)
    assert_array_equal(found["year"], 2011 - np.arange(10))
    # The thick year may be two, and all years below it a year older.
    assert_array_equal(found["flag"][:, 0], [0, 0, 0, 1, 1, 1, 1, 1, 1, 1])
    year_m[4] = 0.3
    year_m[7] = 0.09
    found = accumulation(layers_of(below_s(water_of(year_m))), DENSITY, annual=True)
    assert_array_equal(found["year"], 2011 - np.arange(10))
    # A thin year may belong to the one above or below.
    assert_array_equal(found["flag"][:5, 0], np.zeros(5))
    assert (found["flag"][7:, 0] == 1).all()


def test_named_layers_are_certain_and_so_is_what_lies_between_them_if_it_fits(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    every = {f"snow_{n}": 2012 - n for n in range(1, 12)}
    for annual in (True, False):
        found = accumulation(layers, DENSITY, year=every, annual=annual)
        assert (found["flag"] == 0).all()
        assert (found["year_confidence"] == 1).all()
    plain = accumulation(layers, DENSITY, year=2011)
    two = accumulation(layers, DENSITY, year={"snow_1": 2011, "snow_9": 2003})
    assert (two["year_confidence"].sel(year=2003) == 1).all()
    assert (two["year_confidence"] >= plain["year_confidence"] - 1e-3).all()


def test_a_layer_seen_elsewhere_dates_what_lies_below_it(year_m):
    # The uppermost horizon lies on the first half alone, its like on the other is the second.
    times = below_s(water_of(year_m))
    times[0, 200:] = np.nan
    found = accumulation(layers_of(times), DENSITY, year=2011)
    assert np.isnan(found["accumulation_m_we"][0, 200:]).all()
    assert_allclose(found["accumulation_m_we"][1:, 200:], year_m[2:, 200:], rtol=1e-9)
    assert np.isnan(found["open_m_we"][200:]).all()


def test_years_are_fixed_by_names(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    found = accumulation(layers, DENSITY, year={"snow_3": 2008})
    assert found["year"][0] == 2010
    # Two years more than there seem to be: they lie between these two.
    fixed = accumulation(layers, DENSITY, year={"snow_3": 2008, "snow_4": 2005})
    assert_array_equal(fixed["n_years"].sel(year=[2008, 2007, 2006, 2005])[:, 0], [3, 3, 3, 1])
    assert fixed["year"][-1] == 2010 - 11
    # Six layers for four years: no two get the same.
    crowded = accumulation(layers, DENSITY, year={"snow_2": 2010, "snow_7": 2006})
    assert crowded["accumulation_m_we"].notnull().any("slow_time").all()


def test_a_gap_of_many_years_is_counted_and_said():
    water_m = water_of(np.full((40, N_LINES), 0.3))
    times = np.delete(below_s(water_m), np.arange(10, 29), axis=0)
    with pytest.warns(UserWarning, match="up to 20 years lie between two picks"):
        found = accumulation(layers_of(times), DENSITY, year=2011)
    assert_allclose(found["accumulation_m_we"], 0.3, rtol=1e-9)


def test_without_a_density_firn_is_that_of_the_place_in_greenland(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    layers["Elevation"] = layers["Elevation"] + 2500.0
    layers["Longitude"] = layers["Longitude"] - 45.0
    found = accumulation(layers, year=2011)
    ground_m = 2500 - SPEED_OF_LIGHT_M_S * 3e-6 / 2
    # Line by line, over .02 degrees of latitude.
    assert_allclose(
        found.attrs["temperature_k"], temperature_fausto09(ground_m, 70.01, -45), atol=0.01
    )
    given = accumulation(layers, 340, year=2011, temperature_k=found.attrs["temperature_k"])
    assert_allclose(found["accumulation_m_we"], given["accumulation_m_we"])
    east = layers.assign(Longitude=layers["Longitude"] + 360)
    assert accumulation(east, year=2011).attrs == found.attrs
    for elsewhere in (east.assign(Longitude=0 * east["Longitude"]), layers.drop_vars("Elevation")):
        with refusal("density: unknown outside Greenland"):
            accumulation(elsewhere, year=2011)


# Firn temperatures of boreholes: Clausen et al. (1988), GRIP: Johnsen et al. (1995) [deg C].
@pytest.mark.parametrize(
    ("latitude", "longitude", "height_m", "celsius"),
    [(77.18, -61.11, 1885, -24), (65.18, -43.83, 2480, -20), (72.58, -37.64, 3230, -32)],
)
def test_temperatures_of_greenland_are_near_those_of_boreholes(
    latitude, longitude, height_m, celsius
):
    # Air of 1996-2006 is warmer than old firn: by 2 to 4 K.
    found = temperature_fausto09(height_m, latitude, longitude) - 273.15
    assert_allclose(found, celsius + 3, atol=1.5)


def test_a_profile_of_one_density_is_that_density_and_ends_where_it_ends(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    depth_m = np.arange(0.05, 5, 0.1)
    profile = Profile(depth_m, np.full(depth_m.size, DENSITY), "", np.full(depth_m.size, 0.1))
    found = accumulation(layers, profile, year=2011)
    whole = accumulation(layers, DENSITY, year=2011)
    shallow = found.sizes["year"]
    assert 4 <= shallow < 8
    measured = np.isfinite(found["accumulation_m_we"].values)
    values = whole["accumulation_m_we"].values[:shallow]
    assert_allclose(found["accumulation_m_we"].values[measured], values[measured], rtol=1e-9)
    n_below = (1000 * water_of(year_m) / DENSITY > 5).sum()
    assert found.attrs["n_below_profile"] == n_below


def test_firn_of_a_climate_gives_the_accumulation_it_was_drawn_with():
    climate = Climate(accumulation_m=0.4, variability=0.15, density_sd_kg_m3=0)
    _, layers = simulate(climate, "snow-2012", n_range_lines=N_LINES, rng=3)
    found = accumulation(
        layers_of((layers["twtt"] - layers["twtt"][0]).values[1:]),
        340.0,
        year=2011,
        temperature_k=243.0,
    )
    true_m = np.diff(layers["water_m"].values, axis=0)[1:]
    single = found["n_years"].values == 1
    assert single.mean() > 0.8
    # The climate's mean, .4, is not that of these twenty years, and slabs are of one density each.
    ratio = found["accumulation_m_we"].values / true_m[: found.sizes["year"]]
    assert_allclose(ratio[single], 1, atol=0.02)


AS_IT_IS = xr.Dataset.copy


@pytest.mark.parametrize(
    ("change", "options", "message"),
    [
        (lambda x: x.isel(layer=slice(1, None)), {}, "expected the surface first"),
        (
            lambda x: x.assign(confidence=0 * x["twtt"] + 0.1),
            {},
            "of confidence 0.5 or more, found surface, snow_1",
        ),
        (lambda x: x.isel(layer=slice(2)), {}, "expected two horizons on a range line above"),
        (lambda x: x.assign(twtt=-x["twtt"]), {}, "layers must increase strictly with depth"),
        (AS_IT_IS, {"density": 30.0}, "density .* must be finite, at least 50, .* got 30"),
        (AS_IT_IS, {"density": 950.0}, "at most 917, got 950"),
        (
            AS_IT_IS,
            {"temperature_k": -20.0},
            "temperature_k must be .* at least 200, .* got -20",
        ),
        (
            AS_IT_IS,
            {"density": Profile(np.ones(1), np.ones(1), ""), "temperature_k": 250.0},
            "temperature_k: expected none beside a profile",
        ),
        (lambda x: x.isel(layer=[0]), {}, "and others below it .*, found surface$"),
        (AS_IT_IS, {"year": {"snow_99": 2008}}, "year: expected names of layers with picks"),
        (AS_IT_IS, {"year": {"snow_3": 2008, "snow_4": 2008}}, "years that fall from each"),
        (AS_IT_IS, {"year": 2012}, "none after 2011, found .'snow_1': 2012"),
        (AS_IT_IS, {"year": 1999.7}, "year must be a whole number of at least 0, got 1999.7"),
        (
            AS_IT_IS,
            {"year": {"snow_3": 2008, "snow_4": 2002}},
            "6. years contradict their snow",
        ),
        (
            AS_IT_IS,
            {"year": {"snow_3": 2008, "snow_6": 2004}, "annual": True},
            "as many years from name to name as layers, found .1. more",
        ),
        (
            AS_IT_IS,
            {"density": Profile(np.array([0.1, 0.2]), np.array([400.0, 400.0]), "")},
            "above 0.25 m, where density ends",
        ),
    ],
)
def test_what_tells_no_accumulation_is_refused_in_a_line(year_m, change, options, message):
    options = {"density": DENSITY, "year": 2011} | options
    with refusal(message):
        accumulation(change(layers_of(below_s(water_of(year_m)))), **options)


@pytest.fixture
def files(tmp_path, year_m):
    """Layers of two frames of a segment, as files."""
    layers = layers_of(below_s(water_of(year_m)))
    paths = [tmp_path / f"Data_20120330_04_{number:03d}_layers.nc" for number in (1, 2)]
    for path, lines in zip(paths, (slice(0, 150), slice(150, N_LINES)), strict=True):
        write_dataset(path, layers.isel(slow_time=lines))
    return [str(path) for path in paths]


def test_the_command_writes_a_table_and_a_picture(tmp_path, year_m, files, capsys):
    path = tmp_path / "accumulation.csv"
    main(["accumulation", *files, "-o", str(path), "--density", "400", "--png"])
    assert "4000 rows of 10 years; uppermost horizon snow_1=2011\n" in capsys.readouterr().out
    rows = pd.read_csv(path)
    assert rows.columns.tolist() == [
        "frame",
        "time",
        "lat",
        "lon",
        "year",
        "depth_m",
        "thickness_m",
        "accumulation_m_we",
        "low",
        "high",
        "year_confidence",
        "age_low",
        "age_high",
        "n_years",
        "flag",
        "open_m_we",
    ]
    assert rows["frame"].unique().tolist() == ["Data_20120330_04_001", "Data_20120330_04_002"]
    first = rows[rows["lat"] == 70].set_index("year")["accumulation_m_we"]
    assert_allclose(first[2011 - np.arange(10)], year_m[1:, 0], rtol=1e-8)
    assert path.with_suffix(".png").stat().st_size > 10_000
    with pytest.raises(SystemExit):
        main(["accumulation", *files, "-o", str(path), "--year", "2011"])
    assert "the file is there, --force writes over it" in capsys.readouterr().err


def test_density_of_the_command_may_be_a_profile_and_years_may_be_named(tmp_path, files, capsys):
    core = tmp_path / "core.csv"
    depth_m = np.arange(0.05, 20, 0.1)
    pd.DataFrame({"depth_m": depth_m, "density_kg_m3": 400.0}).to_csv(core, index=False)
    path = tmp_path / "a.csv"
    named = ["--year", "snow_3=2008", "--year", "snow_4=2007"]
    main(["accumulation", *files, "-o", str(path), "--density", str(core), *named])
    assert "core.csv: 200 samples from 0.05 to 19.95 m" in capsys.readouterr().out
    assert set(pd.read_csv(path)["year"]) == set(range(2001, 2011))
    with pytest.raises(SystemExit):
        main(["accumulation", *files, "-o", str(path), *named, "--year", "snow_3=2007", "--force"])
    assert "NAME=YEAR of layers that differ, got" in capsys.readouterr().err


@pytest.mark.parametrize("year", ["99", "snow_2=998", "20111", "0"])
def test_a_year_of_other_than_four_digits_is_refused(tmp_path, files, year, capsys):
    with pytest.raises(SystemExit):
        main(["accumulation", *files, "-o", str(tmp_path / "a.csv"), "--year", year])
    told = f"error: --year: expected four digits, such as 2012, got {year.rpartition('=')[2]}\n"
    assert capsys.readouterr().err == told


def test_the_organizer_beside_layer_files_is_left_out(tmp_path, year_m):
    layers = layers_of(below_s(water_of(year_m)))
    frames = {n: layers.isel(slow_time=slice(150 * n, 150 * n + 150)) for n in range(2)}
    paths = write_layer_files(tmp_path, "20170404_01", frames)
    assert paths[-1].name == "layer_20170404_01.mat"
    options = ["-o", str(tmp_path / "a.csv"), "--density", "400"]
    main(["accumulation", *map(str, sorted(paths)), *options])
    assert len(open_segment(iter(paths))["slow_time"]) == 300
    # Alone it is no layers, and that is said.
    with refusal("expected CReSIS layers .* found a CReSIS layer organizer"):
        open_segment(paths[-1:])


def test_a_table_has_no_row_without_accumulation(year_m):
    times = below_s(water_of(year_m))
    times[3:, 100:] = np.nan
    rows = table(accumulation(layers_of(times), DENSITY, year=2011))
    assert len(rows) == 100 * 10 + 300 * 2
    assert rows["accumulation_m_we"].notna().all()


def test_the_table_by_year_has_means_and_what_they_rest_on(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    rows = by_year(accumulation(layers, DENSITY, year=2011))
    assert_array_equal(rows["year"], 2011 - np.arange(10))
    assert_allclose(rows["accumulation_m_we"], year_m[1:].mean(axis=1), rtol=1e-9)
    # 399 steps of 5e-5 degrees are 2.2 km: three are begun.
    assert (rows["independent_km"] == 3).all()
    picks = year_m[1:] * np.sqrt(2) * ERROR_S / below_s(year_m[1:])
    assert_allclose(rows["error_picks"], picks.mean(axis=1) / np.sqrt(3), rtol=1e-6)


def test_pieces_for_a_map_hold_every_range_line_once(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    layers["Latitude"][100:110] = np.nan
    layers["Longitude"][:] = np.where(np.arange(N_LINES) < 200, 179.999, -179.999)
    rows = pieces(table(accumulation(layers, DENSITY, year=2011)))
    assert len(rows) == 10 * 5  # 2.2 km in pieces of 500 m
    assert sum(len(line) for line in rows["line"]) == 10 * (N_LINES - 10)
    assert_allclose(rows["line"][0][0], [179.999, 70])
    # Lines go on past 180 degrees, none around the Earth.
    assert max(np.ptp(line[:, 0]) for line in rows["line"]) < 0.01
    with refusal("a map needs Latitude and Longitude"):
        pieces(table(accumulation(layers.drop_vars("Latitude"), DENSITY, year=2011)))


def test_other_endings_write_netcdf_and_a_map_and_it_is_said_if_none_is_counted(
    tmp_path, files, capsys
):
    pyogrio = pytest.importorskip("pyogrio", reason="pyogrio is not installed: snowsim[gis]")
    options = ["--year", "2011", "--density", "400"]
    for ending in (".nc", ".gpkg"):
        main(["accumulation", *files, "-o", str(tmp_path / f"a{ending}"), *options, "--force"])
    by_hand = xr.load_dataset(files[0]).drop_vars("confidence")
    by_hand.to_netcdf(tmp_path / "b_layers.nc")
    main(["accumulation", str(tmp_path / "b_layers.nc"), "-o", str(tmp_path / "b.csv"), *options])
    assert "every layer is taken for a year" in capsys.readouterr().out
    with xr.open_dataset(tmp_path / "a.nc") as found:
        assert found["year_confidence"].dims == ("year", "slow_time")
    _, _, lines, values = pyogrio.raw.read(tmp_path / "a.gpkg")
    assert len(lines) == 50
    assert (values[0] > 2000).all()
    assert (tmp_path / "a_years.csv").is_file()


def test_crusts_among_horizons_are_left_out_and_keep_the_snow(rng):
    year_m = 0.35 * np.exp(0.15 * rng.standard_normal((20, 1))) * np.ones((1, N_LINES))
    water_m = water_of(year_m)
    crusts = [4, 9, 14]
    between = 0.6 * water_m[crusts] + 0.4 * water_m[[n + 1 for n in crusts]]
    times = below_s(np.sort(np.vstack([water_m, between]), axis=0))
    found = accumulation(layers_of(times), DENSITY)
    assert found.attrs["no_horizon"] == "snow_6, snow_12, snow_18"
    assert_allclose(found["accumulation_m_we"], year_m[1:], rtol=1e-9)


def test_an_expected_accumulation_decides_where_layers_do_not(rng):
    # A horizon of two is seen, all along: alone, layers look like years.
    year_m = 0.3 * np.exp(0.1 * rng.standard_normal((20, 1))) * np.ones((1, N_LINES))
    layers = layers_of(below_s(water_of(year_m)[::2]))
    alone = accumulation(layers, DENSITY)
    assert_allclose(alone.attrs["typical_m"], 0.6, rtol=0.1)
    contradiction = "expected_m: 0.25 m w.e. a year were expected, with a relative error of 0.1; by"
    with pytest.warns(UserWarning, match=contradiction):
        found = accumulation(layers, DENSITY, expected_m=0.25, expected_error=0.1)
    with pytest.warns(UserWarning, match="expected_m: 0.4 m w.e. a year were expected, with a rel"):
        accumulation(layers, DENSITY, expected_m=0.4, expected_error=0.03, year=2011)
    with warnings.catch_warnings():  # within a factor of 2 of what is roughly known
        warnings.simplefilter("error")
        accumulation(layers, DENSITY, expected_m=0.4, year=2011)
    assert (found["n_years"].isel(slow_time=0) == 2).mean() > 0.8
    assert_allclose(found["accumulation_m_we"].mean(), 0.3, rtol=0.1)
    with refusal("expected_m must be .* at least 0.001, at most 10, got -1"):
        accumulation(layers, DENSITY, expected_m=-1.0)
    with refusal("expected_error must be finite, above 0, got 0"):
        accumulation(layers, DENSITY, expected_m=0.3, expected_error=0)


def parts_behind_a_gap(year_m):
    """Layers of a track whose second half, behind a gap, has names of its own, as of `track`."""
    times = below_s(water_of(year_m))
    first, second = times.copy(), times.copy()
    first[:, N_LINES // 2 :] = np.nan
    second[:, : N_LINES // 2] = np.nan
    return layers_of(np.vstack([first, second]))


def test_numbers_that_begin_anew_behind_a_gap_leave_the_snow_as_it_is(rng):
    year_m = 0.3 * np.exp(0.15 * rng.standard_normal((14, 1))) * np.linspace(1, 1.02, N_LINES)
    layers = parts_behind_a_gap(year_m)
    found = accumulation(layers, DENSITY)
    assert_allclose(found.attrs["typical_m"], 0.3, rtol=0.15)
    of_year = found["accumulation_m_we"]
    assert (
        ((found["low"] < 0.3 * 1.5) & (found["high"] > 0.3 / 1.5))
        .where(of_year.notnull(), True)
        .all()
    )
    # The order of layers in a dataset is no part of what they say.
    shuffled = layers.isel(layer=[0, *(1 + rng.permutation(28))])
    again = accumulation(shuffled, DENSITY)
    for name in ("year", "accumulation_m_we", "year_confidence", "low", "high"):
        assert_allclose(again[name], found[name])


def test_layers_that_nobody_corrected_are_counted_without_a_confidence(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    without = layers.drop_vars("confidence")
    assert accumulation(without, DENSITY).attrs["annual"] == 1  # type 1 is manual
    automatic = without.assign(type=2 * without["type"])
    automatic["type"][0] = 1  # of the surface
    with pytest.warns(UserWarning, match="all picks are automatic by their type, so years are cou"):
        counted = accumulation(automatic, DENSITY)
    assert counted.attrs["annual"] == accumulation(layers, DENSITY).attrs["annual"] == 0
    automatic["twtt"].attrs["place"] = "interface"  # of simulated snow
    assert accumulation(automatic, DENSITY).attrs["annual"] == 1
    automatic["twtt"].attrs["place"] = "peak"
    automatic["type"][3, 7] = 1
    assert accumulation(automatic, DENSITY).attrs["annual"] == 1


def test_invented_times_date_nothing_unless_a_year_is_named(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    invented = np.datetime64("2000-01-01", "ns") + np.arange(N_LINES) * np.timedelta64(1, "ms")
    layers = layers.assign_coords(slow_time=invented)
    with refusal("layers: slow_time: expected the time of the flight, .* found invented ones"):
        accumulation(layers, DENSITY)
    with refusal("give the year of snow_1"):
        accumulation(layers, DENSITY, year={"snow_3": 2009})
    found = accumulation(layers, DENSITY, year={"snow_1": 2011, "snow_3": 2009})
    assert found.attrs["uppermost"] == "snow_1=2011"
    assert accumulation(layers, DENSITY, year=2011)["year"][0] == 2011


def test_half_of_the_lines_say_on_which_side_of_the_equator_a_flight_was(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    north = accumulation(layers, DENSITY).attrs["last_autumn"]
    one_bad_fix = layers.copy(deep=True)
    one_bad_fix["Latitude"][5] = -1
    assert accumulation(one_bad_fix, DENSITY).attrs["last_autumn"] == north == 2011
    south = layers.assign(Latitude=-layers["Latitude"])
    assert accumulation(south, DENSITY).attrs["last_autumn"] == 2012
    for unknown in (
        layers.drop_vars("Latitude"),
        layers.assign(Latitude=np.nan * layers["Latitude"]),
    ):
        with pytest.warns(UserWarning, match="no positions: snow years are taken to end in August"):
            assert accumulation(unknown, DENSITY).attrs["last_autumn"] == north


def test_an_error_of_what_is_not_expected_is_refused(tmp_path, files, capsys):
    with pytest.raises(SystemExit):
        main(["accumulation", *files, "-o", str(tmp_path / "a.csv"), "--expected-error", "0.2"])
    assert "--expected-error is of --expected, which is missing" in capsys.readouterr().err


def test_positions_at_0_0_on_all_lines_are_missing(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    nowhere = layers.assign(Latitude=0 * layers["Latitude"], Longitude=0 * layers["Longitude"])
    with refusal("density: unknown outside Greenland, or without positions"):
        accumulation(nowhere, year=2011)
    with refusal("a map needs Latitude and Longitude"):
        pieces(table(accumulation(nowhere, DENSITY, year=2011)))


def test_layers_that_no_organizer_names_are_said_to_lack_it(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    unnamed = layers.assign_coords(layer=[f"id {n}" for n in range(layers.sizes["layer"])])
    with refusal("no organizer file layer_SEGMENT.mat beside them names layers"):
        accumulation(unnamed, DENSITY)


def test_what_is_no_dataset_or_no_probability_is_refused_in_one_line(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    with refusal("layers: expected a dataset, as snowsim.io.open_segment reads .*, got str"):
        accumulation("20120330_04_layers.nc")
    with refusal("layers: confidence must be finite, at least 0, at most 1, got 90"):
        accumulation(layers.assign(confidence=100 * layers["confidence"]), DENSITY)


def test_years_that_the_tracker_may_merge_are_not_dated(tmp_path, rng):
    year_m = 0.05 * np.exp(0.3 * rng.standard_normal((14, 1))) * np.ones((1, N_LINES))
    layers = layers_of(below_s(water_of(year_m))).assign_attrs(apart_s=float(below_s(0.025)))
    with pytest.warns(UserWarning, match="nothing is dated, rows have depth and mass between"):
        found = accumulation(layers, DENSITY)
    assert found.sizes["year"] == 0
    rows = table(found)
    assert len(rows) == 14 * N_LINES
    assert_allclose(rows["mass_m_we"].to_numpy()[:14], year_m[:, 0], rtol=1e-9)
    assert len(by_year(found)) == 0
    with refusal("a map needs years, nothing is dated"):
        pieces(rows)
    write_dataset(tmp_path / "a_layers.nc", layers)
    main(
        [
            "accumulation",
            str(tmp_path / "a_layers.nc"),
            "-o",
            str(tmp_path / "a.csv"),
            "--density",
            "400",
        ]
    )
    assert "name" in pd.read_csv(tmp_path / "a.csv")
    assert accumulation(layers, DENSITY, year=2011).sizes["year"] > 0
    wide = layers.assign_attrs(apart_s=float(below_s(0.012)))
    assert accumulation(wide, DENSITY).sizes["year"] > 0


def test_layers_about_as_close_as_the_tracker_separates_have_no_quality_1():
    echogram, _ = simulate(Climate(accumulation_m=0.3), "snow-2012", n_range_lines=16, rng=1)
    line = np.arange(16)
    bin_s = 1e-10
    grid = SimpleNamespace(
        n_lines=16, line=line.astype(float), bin_s=bin_s, twtt=lambda rows: 3e-6 + bin_s * rows
    )
    canonical = SimpleNamespace(
        grid=grid, outside=False, surface_db=np.zeros(16), echogram=echogram
    )
    # Two layers are 5 rows apart, the tracker separates 4; the others are 20 from any.
    rows = np.array([10.0, 30.0, 50.0, 55.0, 75.0])
    pieces = [(Piece(line, np.full(16, row), np.ones(16)), np.full(16, 0.95)) for row in rows]
    found = layers_of_frame(canonical, pieces, 0)
    assert_array_equal(found["quality"], np.repeat([[1], [1], [2], [2], [1]], 16, axis=1))
    # Accumulation dates nothing if years are about as thin.
    assert_allclose(found.attrs["apart_s"], 4 * bin_s, rtol=1e-12)


def columns_of(year_m):
    """Layers between years (year,) [m w.e.], the same on eight lines, and their `Series`."""
    water_m = np.cumsum(year_m)
    relative = ERROR_S / below_s(1.0)
    flown = pd.Timestamp("2012-03-30") + pd.DateOffset(months=4)
    series = Series(
        above_m=water_m,
        span_m=water_m - water_m[:, None],
        error_m=np.full(water_m.size, relative / 1.645),
        disjoint=np.zeros((water_m.size, water_m.size), bool),
        confidence=np.full(water_m.size, 0.9),
        elapsed=flown.day_of_year / 366,
        known={},
    )
    return layers_of(below_s(np.repeat(water_m[:, None], 8, axis=1))), series


# Masses of years that are unresolved with a probability of .06 to .1, and of .1 to .17.
@pytest.mark.parametrize(("apart_m", "is_dated"), [(0.04, True), (0.041, False)])
def test_nothing_is_dated_if_a_year_is_unresolved_with_a_probability_of_a_tenth(apart_m, is_dated):
    year_m = 0.001 * np.array([60, 105, 88, 90, 54, 157, 133, 92, 121, 107, 87, 128, 93])
    layers, series = columns_of(year_m)
    # A year is resolved if it has two and a half times the mass that the tracker separates.
    doubt = posterior(replace(series, separable_m=apart_m)).below(2.5 * apart_m)
    assert (0.06 < doubt < 0.1) if is_dated else (0.1 < doubt < 0.17)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = accumulation(layers.assign_attrs(apart_s=float(below_s(apart_m))), DENSITY)
    assert (found.sizes["year"] > 0) == is_dated


def test_ages_lie_within_their_limits_in_nine_of_ten_cases():
    layers, series = columns_of([0.45, 0.23, 0.33, 0.17, 0.38, 0.45, 0.26, 0.35, 0.33, 0.26])
    found = accumulation(layers, DENSITY).isel(slow_time=0)
    assert_allclose(found["depth_m"], 1000 * series.above_m[:-1] / DENSITY, rtol=1e-9)
    age = posterior(series).age[:-1]
    younger = np.cumsum(age, axis=1) / age.sum(axis=1, keepdims=True)
    # The limits hold the stated age, too.
    stated = found.attrs["last_autumn"] - found["year"]
    assert_array_equal(found["age_low"], np.minimum((younger < 0.05).sum(axis=1), stated))
    assert_array_equal(found["age_high"], np.maximum((younger < 0.95).sum(axis=1), stated))
    # Ages are doubtful enough to be others between other limits.
    for low, high in ((0.025, 0.05), (0.05, 0.1), (0.9, 0.95), (0.95, 0.975)):
        assert ((younger > low) & (younger < high)).any()


def test_a_gap_of_ten_years_is_not_worth_a_warning():
    layers, _ = columns_of([0.15, 0.3, 0.3, 3.0, 0.3, 0.3, 0.3])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = accumulation(layers, DENSITY, year=2011)
    assert found["n_years"].max() == 10


def test_confidence_counts_up_to_95_percent_and_is_90_percent_where_it_is_missing():
    layers, _ = columns_of([0.15, 0.3, 0.16, 0.3, 0.3, 0.17, 0.3])

    def sure(confidence):
        given = layers.assign(confidence=xr.full_like(layers["twtt"], confidence))
        found = accumulation(given, DENSITY, annual=False)
        return found["year_confidence"].values

    assert_allclose(sure(1.0), sure(0.95), rtol=1e-9)
    assert_allclose(sure(np.nan), sure(0.9), rtol=1e-9)
    for one, other in ((0.95, 0.94), (0.95, 0.9), (0.9, 0.89)):
        assert np.nanmax(np.abs(sure(one) - sure(other))) > 1e-4


@pytest.mark.parametrize(
    ("year_m", "remedy"),
    [
        # The mass of a typical year is known to 23 %, and to 10 %.
        ([0.15, 0.3, 0.3, 0.5], "the accumulation of the place"),
        ([0.15, 0.3, 0.3, 0.5, 0.3, 0.3, 0.3, 0.3], "a core, or the name of a layer"),
    ],
)
def test_an_expected_accumulation_would_help_if_a_typical_year_is_vague(year_m, remedy):
    layers, _ = columns_of(year_m)
    assert remedy in accumulation(layers, DENSITY, year=2011).attrs["surety"]


def test_firn_is_that_of_the_accumulation_that_is_found():
    # Thirty years of 1.2 m w.e., to 60 m depth: the first guess of .3 m is far off.
    water_m = 1.2 * (0.5 + np.arange(30))
    depth_m = depth_herron_langway80(water_m, 1.2, 243.0, 340.0)
    times = np.repeat(travel_time_s(depth_m, water_m)[:, None], 8, axis=1)
    found = accumulation(layers_of(times), 340.0, annual=True, temperature_k=243.0)
    # After one round it is 8 % too large; after two, years of firn are .1 % off at most.
    assert_allclose(found["accumulation_m_we"], 1.2, rtol=2e-3)


def test_layers_on_parts_of_the_track_have_the_mass_that_they_would_have_on_all_of_it():
    # Accumulation grows along track; each layer lies on six tenths of it.
    lines = np.arange(N_LINES)
    water_m = (0.15 + 0.3 * np.arange(10))[:, None] * np.exp(lines / N_LINES)
    for layer in range(10):
        first = layer % 4 * 160 // 3
        water_m[layer, (lines < first) | (lines >= first + 240)] = np.nan
    rows = np.vstack([np.zeros(N_LINES), water_m])
    picks = SimpleNamespace(
        error_s=0 * rows, below_s=rows, doubt=0 * rows, last_autumn=2011, elapsed=0.58
    )
    series = median_series(rows, picks, {})
    assert_allclose(series.above_m / series.above_m[0], 1 + 2 * np.arange(10), rtol=1e-9)
    assert_allclose(np.diag(series.span_m, 1), 2 * series.above_m[0], rtol=1e-9)


def test_a_layer_on_parts_of_the_track_has_one_age_with_its_like_on_the_others(year_m):
    # Two layers have another name on the second half: no line has both.
    times = below_s(water_of(year_m))
    rows = []
    for number, own in enumerate(times):
        left, right = own.copy(), own.copy()
        left[220:] = np.nan
        right[:180] = np.nan if number in (3, 7) else right[:180]
        right[180:220] = np.nan
        rows += [left, right] if number in (3, 7) else [own]
    found = accumulation(layers_of(np.array(rows)), DENSITY)
    assert_array_equal(found["year"], 2011 - np.arange(10))
    assert_allclose(found["accumulation_m_we"][:, :180], year_m[1:, :180], rtol=1e-9)
    assert_allclose(found["accumulation_m_we"][:, 220:], year_m[1:, 220:], rtol=1e-9)
    # A part of the track that shares no layer with the other is doubtful, and it is said.
    left, right = times.copy(), times.copy()
    left[:, 180:] = np.nan
    right[:, :220] = np.nan
    found = accumulation(layers_of(np.stack([left, right], axis=1).reshape(-1, N_LINES)), DENSITY)
    assert (found["flag"].isel(year=slice(3, None)).max("slow_time") == 1).all()


def test_fixes_at_zero_degrees_are_missing_fixes(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    layers["Elevation"] = layers["Elevation"] + 2500.0
    layers["Longitude"] = layers["Longitude"] - 45.0
    sound = accumulation(layers)
    for name in ("Latitude", "Longitude"):
        layers[name] = layers[name].copy()
        layers[name][5::37] = 0
    found = accumulation(layers)
    assert_allclose(found.attrs["temperature_k"], sound.attrs["temperature_k"], atol=1e-3)
    assert_array_equal(by_year(found)["independent_km"], by_year(sound)["independent_km"])
    assert np.isnan(found["Latitude"][5])


def test_every_variable_has_a_unit_and_a_meaning(year_m):
    found = accumulation(layers_of(below_s(water_of(year_m))), DENSITY)
    for name, variable in found.variables.items():
        if name != "slow_time":  # whose unit a file has
            assert {"units", "long_name"} <= set(variable.attrs), name


def test_the_command_says_how_many_dates_are_sure_and_what_would_help(tmp_path, files, capsys):
    options = ["-o", str(tmp_path / "a.csv"), "--density", "400"]
    main(["accumulation", *files, *options, "--expected", "0.3", "--expected-error", "0.1"])
    assert "11 of 11 dates are right with a probability of 0.8 or more\n" in capsys.readouterr().out
    for path in files:  # without the first five horizons
        xr.load_dataset(path).isel(layer=[0, *range(6, 12)]).to_netcdf(path)
    main(["accumulation", *files, *options, "--force"])
    assert "the name of a layer whose year is known (--year NAME=YEAR)" in capsys.readouterr().out


MOST_YEARS = 26
N_GISP2 = 7


@pytest.fixture(scope="module")
def cores(shared_data):
    """Masses of years [m w.e.], the newest first: 16 cores of GreenTrACS, 7 stretches of GISP2."""
    folder = shared_data / "snow_radar" / "cores"
    if not folder.is_dir():
        pytest.skip(f"no cores: {folder} is no folder")
    columns = np.genfromtxt(folder / "greentracs" / "Accumulation.txt").T[:-1]
    series = [core[np.isfinite(core)][:MOST_YEARS] for core in columns]
    gisp2 = np.loadtxt(folder / "summit" / "gisp2_accum_1939_1743_kgm2.txt") / 1000
    series += [part[:MOST_YEARS] for part in np.split(gisp2[: N_GISP2 * 28], N_GISP2)]
    assert len(series) == 23
    return series


def dated(core, picked, **options):
    """Spans of a core, a row each: true `age` of the upper horizon, and whether `n_years` is right.

    The first horizon lies below .6 years' mass; those `picked` are given.
    """
    water_m = water_of(np.append(0.6 * np.median(core), core))
    horizons = pd.DataFrame({"depth_m": 1000 * water_m / DENSITY, "age": np.arange(water_m.size)})
    horizons = horizons[picked]
    layers = layers_of(below_s(np.repeat(water_m[picked, None], 8, axis=1)))
    options = {"year": 2011 - int(horizons["age"].iloc[0])} | options
    found = (
        accumulation(layers, DENSITY, **options).isel(slow_time=0).drop_dims(["below_s", "layer"])
    )
    rows = found.to_dataframe().dropna(subset="depth_m").reset_index()
    near = {"on": "depth_m", "tolerance": 1e-6, "direction": "nearest"}
    rows = pd.merge_asof(rows, horizons, **near).dropna(subset="age")
    base_m = rows["depth_m"] + rows["n_years"] * rows["thickness_m"]
    base_age = np.interp(base_m, horizons["depth_m"], horizons["age"])
    rows["right"] = np.isclose(base_age - rows["age"], rows["n_years"])
    rows["off"] = np.abs(2011 - rows["year"] - rows["age"])
    rows["within"] = rows["age"].between(rows["age_low"], rows["age_high"])
    return rows


def test_where_every_layer_is_a_year_all_years_of_cores_are_dated_rightly(cores):
    dates = [dated(core, np.ones(core.size + 1, bool), annual=True) for core in cores]
    assert [len(rows) for rows in dates] == [core.size for core in cores]
    rows = pd.concat(dates)
    assert (rows["off"] == 0).all()
    assert rows["flag"].mean() < 0.1


@pytest.fixture(scope="module")
def dates_of(cores):
    """Function from the picked horizons of every core to their dates, without a year."""

    @functools.cache
    def dates_of_numbers(numbers):
        return [
            dated(core, np.isin(np.arange(core.size + 1), own), year=None, annual=False)
            for core, own in zip(cores, numbers, strict=True)
        ]

    return lambda picked: dates_of_numbers(tuple(tuple(np.flatnonzero(own)) for own in picked))


@pytest.mark.parametrize(("n_missing", "right"), [(0, 1), (1, 0.95), (2, 0.5)])
def test_without_a_year_missing_horizons_above_the_first_are_counted(
    cores, dates_of, n_missing, right
):
    # Flown half a year after the autumn of 2011; without the newest horizons.
    dates = dates_of([np.arange(core.size + 1) >= n_missing for core in cores])
    first = pd.concat(each.head(1) for each in dates)
    assert (first["off"] == 0).mean() >= right
    assert first["within"].all()


@pytest.mark.parametrize(("missing", "least_sure"), [(0, 0.5), (0.2, 0.3)])
def test_years_of_cores_are_right_as_often_as_they_say(cores, dates_of, missing, least_sure):
    rng = np.random.default_rng(20)
    rows = pd.concat(dates_of([rng.random(core.size + 1) >= missing for core in cores]))
    right = rows["off"] == 0
    assert rows["within"].mean() > 0.85
    # 23 cores: the error of the share that is right is about .07.
    assert abs(rows["year_confidence"].mean() - right.mean()) < 0.15
    sure = rows["year_confidence"] >= 0.8
    assert sure.mean() > least_sure
    assert right[sure].mean() > 0.9


def test_the_bottom_is_no_autumn(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    with_it = layers.isel(layer=[*range(11), 10])
    with_it = with_it.assign_coords(layer=[*layers["layer"].values[:11], "Bottom"])
    with_it["twtt"][-1] += 1e-6
    layers = layers.isel(layer=slice(0, 11))
    with pytest.warns(UserWarning, match="the layer bottom is left out"):
        found = accumulation(with_it, DENSITY, year=2011)
    xr.testing.assert_identical(found, accumulation(layers, DENSITY, year=2011))


@pytest.mark.parametrize("years", [3, 30])
def test_a_last_year_of_unlikely_thickness_is_flagged(year_m, years):
    year_m[-1] *= years
    found = accumulation(layers_of(below_s(water_of(year_m))), DENSITY, annual=True)
    assert_array_equal(found["flag"][:, 0], [0] * 9 + [1])


def test_bad_picks_without_confidence_are_told(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    layers["quality"][3, :7] = 3
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", "layers: snow of")
        accumulation(layers, DENSITY)
    without = layers.drop_vars("confidence")
    with pytest.warns(UserWarning, match="7 picks have quality 3, bad, .*, of snow_3: correct"):
        accumulation(without, DENSITY)


def test_a_surface_at_time_0_was_not_picked(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    layers["twtt"][0] = 0
    with refusal("layers: expected the surface first"):
        accumulation(layers, DENSITY)


@pytest.mark.parametrize(("year", "is_noted"), [(2011, False), (2009, False), (1911, True)])
@pytest.mark.parametrize("annual", [True, False])
def test_a_year_that_the_snow_above_contradicts_is_told(year_m, year, is_noted, annual):
    layers = layers_of(below_s(water_of(year_m)))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        accumulation(layers, DENSITY, year=year, annual=annual)
    told = f"year: {year}, 101 years before the flight, was given for a layer under the snow of"
    assert any(told in str(each.message) for each in caught) == is_noted


def test_heights_that_greenland_has_not_are_refused(year_m):
    layers = layers_of(below_s(water_of(year_m)))
    layers["Longitude"] = layers["Longitude"] - 40
    layers["Elevation"] = layers["Elevation"] - 9999
    with refusal(r"layers: Elevation: .* -100 to 3800 m, found it at -1\.0\d+e\+04 m"):
        accumulation(layers)
