"""Dates of annual series of real cores, 24 to 26 years, from picks of every horizon or of most.

16 cores of GreenTrACS and 7 stretches of GISP2, in snow of one density, layers flat.
"""

from dataclasses import dataclass

import numpy as np
import pytest
import xarray as xr

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.snowpack import accumulation

DENSITY = 400.0
N_LINES = 8
NEWEST = 2011
MOST_YEARS = 26
N_GISP2 = 7


pytestmark = pytest.mark.filterwarnings("ignore:layers. snow of:UserWarning")


@pytest.fixture(scope="module")
def cores(shared_data):
    """Masses of years [m w.e.], the newest first, of each core."""
    folder = shared_data / "snow_radar" / "cores"
    if not folder.is_dir():
        pytest.skip(f"no cores: {folder} is no folder")
    columns = np.genfromtxt(folder / "greentracs" / "Accumulation.txt").T[:-1]
    series = [core[np.isfinite(core)][:MOST_YEARS] for core in columns]
    gisp2 = np.loadtxt(folder / "summit" / "gisp2_accum_1939_1743_kgm2.txt") / 1000
    series += [part[:MOST_YEARS] for part in np.split(gisp2[: N_GISP2 * 28], N_GISP2)]
    assert len(series) == 23
    return series


@dataclass
class Dates:
    """Of picked horizons: true ages, those found (NaN where none) and their errors [years].

    Of spans between them: whether they are counted wrongly, and flagged.
    """

    true: np.ndarray
    found: np.ndarray
    error: np.ndarray
    wrong: np.ndarray
    flagged: np.ndarray

    @property
    def inside(self):
        """Whether the true age lies within the error, in whole years, where an age is found."""
        off = np.abs(self.found - self.true)
        return (off <= np.ceil(self.error))[np.isfinite(self.found)]


def layers_of(water_m):
    """Layers of a surface and horizons under masses of snow [m w.e.], picked by a person."""
    optical_m = np.append(0, 1000 * water_m / DENSITY * (1 + 0.845e-3 * DENSITY))
    twtt = np.repeat(3e-6 + 2 * optical_m[:, None] / SPEED_OF_LIGHT_M_S, N_LINES, axis=1)
    on = ("layer", "slow_time")
    content = {name: (on, np.ones(twtt.shape, np.uint8)) for name in ("quality", "type")}
    names = ["surface", *(f"snow_{n}" for n in range(1, len(twtt)))]
    times = np.datetime64("2012-04-01", "ns") + np.arange(N_LINES) * np.timedelta64(40, "ms")
    return xr.Dataset({"twtt": (on, twtt)} | content, {"layer": names, "slow_time": times})


def dated(year_m, picked=None, first=0.6, named=False, **options):
    """`Dates` of a core; the snow above the first horizon is a share `first` of a typical year."""
    water_m = np.cumsum(np.append(first * np.median(year_m), year_m))
    true = np.arange(water_m.size)
    if picked is not None:
        water_m = water_m[picked]
        true = true[picked]
    options = {"year": NEWEST - int(true[0])} | options
    if named:
        options["year"] = {f"snow_{n}": NEWEST - int(age) for n, age in enumerate(true, start=1)}
    result = accumulation(layers_of(water_m), DENSITY, **options).isel(slow_time=0)
    rows = result.drop_dims("below_s").to_dataframe().dropna(subset="depth_m")
    depth_m = 1000 * water_m / DENSITY
    found = np.full(true.size, np.nan)
    error = np.full(true.size, np.nan)
    wrong = []
    flagged = []
    for upper in range(true.size):
        row = rows[np.isclose(rows["depth_m"], depth_m[upper], rtol=0, atol=1e-6)]
        if len(row):
            base_m = row["depth_m"] + row["n_years"] * row["thickness_m"]
            lower = np.abs(depth_m - base_m.item()).argmin()
            found[upper] = NEWEST - row.index[0]
            error[upper] = row["age_error_years"].item()
            wrong.append(row["n_years"].item() != true[lower] - true[upper])
            flagged.append(row["flag"].item() > 0)
    return Dates(true, found, error, np.array(wrong), np.array(flagged))


def of_all(dates, name):
    return np.concatenate([getattr(each, name) for each in dates])


def deepest_error(dates):
    return np.median([each.error[np.isfinite(each.error)][-1] for each in dates])


def test_where_every_layer_is_a_year_all_are_dated_rightly(cores):
    dates = [dated(core) for core in cores]
    # The deepest horizon begins no year.
    assert all((each.found == each.true)[:-1].all() for each in dates)
    assert not of_all(dates, "wrong").any()
    assert of_all(dates, "flagged").mean() < 0.1


@pytest.mark.parametrize("first", [0.2, 0.6])
@pytest.mark.parametrize("annual", [True, False])
def test_no_core_is_shifted_where_the_snow_above_the_first_horizon_is_thin(cores, first, annual):
    assert all(dated(core, first=first, annual=annual).found[0] == 0 for core in cores)


def test_without_a_year_a_first_horizon_that_is_missing_is_counted(cores):
    # Flown half a year after the autumn of 2011; without the newest horizon, or the two newest.
    for missing, right in ((0, 1), (1, 0.95), (2, 0.5)):
        picked = np.arange(MOST_YEARS + 1) >= missing
        dates = [dated(core, picked[: core.size + 1], year=None, annual=False) for core in cores]
        assert np.mean([each.found[0] == each.true[0] for each in dates]) >= right
        assert all(each.inside[0] for each in dates)


def test_counted_years_are_right_within_their_error(cores):
    dates = [dated(core, annual=False) for core in cores]
    assert of_all(dates, "inside").mean() > 0.9
    assert deepest_error(dates) < 2.5
    assert of_all(dates, "flagged").mean() < 0.4
    assert (of_all(dates, "wrong") & ~of_all(dates, "flagged")).mean() < 0.03


def test_counted_years_are_right_within_their_error_where_a_fifth_of_the_horizons_is_missing(cores):
    rng = np.random.default_rng(20)
    picked = [rng.random(core.size + 1) > 0.2 for core in cores for _ in range(2)]
    dates = [
        dated(core, picked=each, annual=False)
        for core, each in zip([core for core in cores for _ in range(2)], picked, strict=True)
    ]
    assert of_all(dates, "inside").mean() > 0.85
    assert deepest_error(dates) < 4
    assert of_all(dates, "flagged").mean() < 0.6
    assert (of_all(dates, "wrong") & ~of_all(dates, "flagged")).mean() < 0.05


@pytest.mark.parametrize("annual", [True, False])
def test_named_layers_have_no_flag_and_no_error(cores, annual):
    dates = [dated(core, named=True, annual=annual) for core in cores]
    assert not of_all(dates, "flagged").any()
    error = of_all(dates, "error")
    assert (error[np.isfinite(error)] == 0).all()
