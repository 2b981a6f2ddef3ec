"""Depth, age and accumulation of layers, against layers whose snow is known."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal

import snowsim
from snowsim.cli import main
from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.io.files import write_dataset
from snowsim.io.profiles import Profile
from snowsim.snowpack.snow import AGE_UNCERTAIN, COLUMNS, COUNT_UNCERTAIN, accumulation, table

N_LINES = 400
DENSITY = 400.0
ERROR_S = 2e-10


def layers_of(below_s, names=None):
    """Layers at travel times below the surface (layer, range_line) [s], the surface above them."""
    twtt = 3e-6 + np.vstack([np.zeros(N_LINES), below_s])
    on = ("layer", "slow_time")
    names = names or [f"snow_{n}" for n in range(1, len(twtt))]
    variables = {"twtt": twtt, "twtt_low": twtt - ERROR_S, "twtt_high": twtt + ERROR_S}
    variables |= {"confidence": np.where(np.isfinite(twtt), 0.9, np.nan)}
    content = {name: (on, values) for name, values in variables.items()}
    content |= {name: (on, np.ones(twtt.shape, np.uint8)) for name in ("quality", "type")}
    latitude = 70 + 5e-5 * np.arange(N_LINES)
    content |= {"Latitude": ("slow_time", latitude), "Longitude": ("slow_time", 0 * latitude)}
    content |= {"Elevation": ("slow_time", 0 * latitude)}
    times = np.datetime64("2012-03-30", "ns") + np.arange(N_LINES) * np.timedelta64(40, "ms")
    return xr.Dataset(content, {"layer": ["surface", *names], "slow_time": times})


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
    assert (found["n_years"] == 1).all()
    # Of errors of two picks, and 5 % of density over the refractive index, for nine of ten.
    picks = np.sqrt(2) * ERROR_S / below_s(year_m[1:])
    half = np.hypot(picks, 1.645 * 0.05 / (1 + 0.845e-3 * DENSITY))
    assert_allclose(found["high"] / found["accumulation_m_we"] - 1, half, rtol=1e-6)
    assert_allclose(1 - found["low"] / found["accumulation_m_we"], half, rtol=1e-6)


def test_a_horizon_that_is_missed_makes_one_span_of_two_years(year_m):
    times = below_s(water_of(year_m))
    times[4, 100:] = np.nan
    times[7, :] = np.nan
    found = accumulation(layers_of(times), DENSITY, year=2011)
    assert_array_equal(found["year"], 2011 - np.arange(10))
    here = slice(200, 300)
    # Spans of the fourth and fifth year, and of the seventh and eighth.
    assert_array_equal(found["n_years"][:, 250], [1, 1, 1, 2, 2, 1, 2, 2, 1, 1])
    assert_array_equal(found["n_years"][:, 50], [1, 1, 1, 1, 1, 1, 2, 2, 1, 1])
    for years in ([3, 4], [6, 7]):
        mean_m = year_m[1:][years].mean(axis=0)[here]
        for year in years:
            assert_allclose(found["accumulation_m_we"][year, here], mean_m, rtol=1e-9)
        # Two years about their mean scatter by .3 / 2^.5, beside errors of the picks and density.
        picks = np.sqrt(2) * ERROR_S / below_s(2 * mean_m)
        density = 0.05 / (1 + 0.845e-3 * DENSITY)
        half = np.hypot(picks, 1.645 * np.hypot(density, 0.3 / np.sqrt(2)))
        assert_allclose(found["high"][years[0], here] / mean_m - 1, half, rtol=1e-6)
        assert_allclose(1 - found["low"][years[1], here] / mean_m, half, rtol=1e-6)
    depth_m = 1000 * water_of(year_m) / DENSITY
    middle_m = (depth_m[3] + depth_m[5]) / 2
    assert_allclose(found["depth_m"][4, here], middle_m[here], rtol=1e-9)


def test_a_pick_between_two_horizons_is_left_out_or_flagged(year_m):
    times = below_s(water_of(year_m))
    between = np.full(N_LINES, np.nan)
    between[150:250] = (0.75 * times[3] + 0.25 * times[4])[150:250]
    names = [f"snow_{n}" for n in range(1, 13)]
    found = accumulation(layers_of(np.insert(times, 4, between, 0), names), DENSITY, year=2011)
    flag = found["flag"].values.astype(int)
    away = np.r_[0:150, 250:N_LINES]
    assert_allclose(found["accumulation_m_we"][:, away], year_m[1:, away], rtol=1e-9)
    same = np.isclose(found["accumulation_m_we"], year_m[1:], rtol=1e-9)
    assert (same | (flag > 0)).all()


def test_a_doubtful_pick_in_the_tail_of_the_surface_is_no_year_unless_it_is_named(year_m):
    tail = below_s(np.full((1, N_LINES), 0.06))
    layers = layers_of(np.vstack([tail, below_s(water_of(year_m))]))
    layers["confidence"][1] = 0.55
    found = accumulation(layers, DENSITY, year=2011)
    assert (found.attrs["uppermost"], found.attrs["no_horizon"]) == ("snow_2=2011", "snow_1")
    assert_allclose(found["accumulation_m_we"], year_m[1:], rtol=1e-9)
    named = accumulation(layers, DENSITY, year={"snow_1": 2011})
    assert named.attrs["uppermost"] == "snow_1=2011"
    # The count from the surface to the first pick is doubtful, but then no age hangs on it.
    shallow = accumulation(layers.isel(layer=[0, 1, 3, 4]), DENSITY, year={"snow_3": 2010})
    assert (shallow["flag"].sel(year=2010) < AGE_UNCERTAIN).all()


def test_first_horizons_that_nobody_picked_are_counted(year_m):
    year_m[0] = 0.3
    found = accumulation(layers_of(below_s(water_of(year_m)[2:])), DENSITY, year=2011)
    assert found.attrs["uppermost"] == "snow_1=2009"
    assert_allclose(found["accumulation_m_we"].sel(year=2009), year_m[3], rtol=1e-9)
    assert np.isnan(found["open_m_we"]).all()


def test_a_doubtful_count_is_flagged_and_so_is_every_deeper_age(year_m):
    water_m = water_of(np.repeat(np.full((11, 1), 0.3), N_LINES, axis=1))
    water_m[5:] += 0.3 * 0.48  # one and a half years between two picks
    flag = accumulation(layers_of(below_s(water_m)), DENSITY, year=2011)["flag"].values.astype(int)
    assert_array_equal(flag[:4], 0)
    assert_array_equal(flag[4] & COUNT_UNCERTAIN, COUNT_UNCERTAIN)
    assert_array_equal(flag[5:] & AGE_UNCERTAIN, AGE_UNCERTAIN)
    assert not (flag[5:] & COUNT_UNCERTAIN).any()


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
    assert_array_equal(fixed["n_years"][2:6, 0], [3, 3, 3, 1])
    assert fixed["year"][-1] == 2010 - 11


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
    climate = snowsim.Climate(accumulation_m=0.4, variability=0.15, density_sd_kg_m3=0)
    _, layers = snowsim.simulate(climate, "snow-2012", n_range_lines=N_LINES, rng=3)
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


@pytest.mark.parametrize(
    ("change", "options", "message"),
    [
        (lambda x: x.isel(layer=slice(1, None)), {}, "expected the surface first"),
        (lambda x: x.isel(layer=slice(2)), {}, "expected two horizons on a range line above"),
        (lambda x: x.assign(twtt=-x["twtt"]), {}, "layers must increase strictly with depth"),
        (lambda x: x, {"density": 30.0}, "density .* must be finite, at least 50, .* got 30"),
        (lambda x: x, {"density": 950.0}, "at most 917, got 950"),
        (
            lambda x: x,
            {"temperature_k": -20.0},
            "temperature_k must be .* at least 200, .* got -20",
        ),
        (lambda x: x.isel(layer=[0]), {}, "and others below it, found surface"),
        (lambda x: x, {"year": {"snow_99": 2008}}, "year: expected names of layers with picks"),
        (lambda x: x, {"year": {"snow_3": 2008, "snow_4": 2008}}, "years that fall from each"),
        (
            lambda x: x,
            {"density": Profile(np.array([0.1, 0.2]), np.array([400.0, 400.0]), "")},
            "above 0.25 m, where density ends",
        ),
    ],
)
def test_what_tells_no_accumulation_is_refused_in_a_line(year_m, change, options, message):
    options = {"density": DENSITY, "year": 2011} | options
    with pytest.raises(ValueError, match=message) as error:
        accumulation(change(layers_of(below_s(water_of(year_m)))), **options)
    assert "\n" not in str(error.value)


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
    main(["accumulation", *files, "-o", str(path), "--year", "2011", "--density", "400", "--png"])
    expected = "4000 rows of 10 years; uppermost horizon snow_1=2011; no horizons: none; 0 picks"
    assert expected in capsys.readouterr().out
    rows = pd.read_csv(path)
    columns = ("frame", "time", "lat", "lon", "year", *COLUMNS)
    assert tuple(rows.columns) == columns
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
    assert "0 picks below the end of the density" in capsys.readouterr().out
    assert table_years(path) == list(range(2001, 2011))


def table_years(path):
    return sorted(pd.read_csv(path)["year"].unique().tolist())


def test_a_table_has_no_row_without_accumulation(year_m):
    times = below_s(water_of(year_m))
    times[3:, 100:] = np.nan
    rows = table(accumulation(layers_of(times), DENSITY, year=2011))
    assert len(rows) == 100 * 10 + 300 * 2
    assert rows["accumulation_m_we"].notna().all()
