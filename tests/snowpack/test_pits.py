"""Pits and cores as people write them, and what a radar sees of them."""

import re

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.testing import assert_allclose
from refusals import refusal

import snowsim
from snowsim import cli
from snowsim.io import read_dataset, read_profile
from snowsim.snowpack import Snowpack


def snow_of(profile):
    return Snowpack.from_profile(
        profile.depth_m, profile.density_kg_m3, thickness_m=profile.thickness_m
    )


@pytest.fixture
def read(tmp_path):
    """Profile of a text, as `read_profile` takes it from a file."""

    def of_text(text, encoding="utf-8", **options):
        (tmp_path / "pit.csv").write_bytes(text.encode(encoding))
        return read_profile(tmp_path / "pit.csv", **options)

    return of_text


@pytest.mark.parametrize(
    "text",
    [
        "depth_m,density_kg_m3\n0.05,310\n0.15,420\n0.25,",
        "Depth (cm);Density (g/cm^3)\n5;.31\n15;.42\n25;NaN",
        "# pit\ndepth mm\tdensity\n50\t.31\n150\t.42\n250\t",
        "depth_m,rho_kgm3,rho_error\n0.05,310,9\n0.15,420,9\n0.25,,9",
        "depth [cm];density [kg/m³]\n5;310\n15;420\n25;",
        "depth (m);density (g/cc)\n0,05;0,31\n0,15;0,42\n0,25;",
        "depth,density,density_error\ncm,kg m-3,kg m-3\n5,310,9\n15,420,9\n25,,9",
        "depth_cm,density_kgm3\n25,\n15,420\n5,310",
        "top_cm,bottom_cm,density_kgm3\n0,10,310\n10,20,420\n20,30,",
        "top_cm,density\n0,310\n10,420\n20,",
        "depth_cm,density\n0,310\n10,420\n20,",
        "depth_cm,thickness_cm,density\n0,10,310\n10,10,420\n20,10,",
        "bottom depth (cm),density\n10,310\n20,420\n30,",
        "depth_cm,thickness_cm,density\n5,10,310\n15,10,420\n25,10,",
        "depth_m,thickness_cm,density\n.05,10,310\n.15,10,420\n.25,10,",
    ],
)
@pytest.mark.filterwarnings("ignore:profile")
def test_a_pit_is_the_same_in_all_the_ways_that_people_write_it(read, text):
    profile = read(text)
    assert_allclose(profile.density_kg_m3, [310, 420, np.nan])
    assert "3 samples" in profile.note
    assert "1 missing" in profile.note
    snow = snow_of(profile)
    assert_allclose(snow.depth_m[:, 0], [0, 0.1])
    assert_allclose(snow.density_kg_m3[:, 0], [310, 420])


def test_a_spreadsheets_own_encoding_is_read(read):
    text = "depth (m),density (kg/m³)\n0.05,310\n0.15,420"
    assert "density in kg m-3" in read(text, encoding="cp1252").note


def test_columns_and_units_that_no_header_tells_are_named(read):
    text = "core,z,A,B\n1,5,310,9\n2,15,420,9"
    named = {"depth_column": "z", "density_column": "A", "depth_unit": "cm"}
    profile = read(text, **named)
    assert_allclose(profile.depth_m, [0.05, 0.15])
    assert profile.note.endswith("depths of the middle of each, depth in cm, density in kg m-3")
    assert read(text, **named, depth_of="bottom").depth_m.tolist() == [0.025, 0.1]


PANGAEA = """/* DATA DESCRIPTION:
Citation:\tA core, in depth and density
Event(s):\tB26 * LATITUDE: 77.25
*/
Depth ice/snow [m]\tDepth w.eq. [m]\tDepth top [m]\tDepth bot [m]\tDensity ice [kg/m**3]
0.05\t0.016\t0.00\t0.10\t310
0.15\t0.052\t0.10\t0.20\t420
"""
SUMUP = """Profile,Citation,Density,Start_Depth,Stop_Depth,Midpoint,Error,SDOS_Flag
7,41,0.310,0,0.1,0.05,-9999,-9999
7,41,-9999,0.1,0.2,0.15,-9999,-9999
7,41,0.420,0.2,0.3,0.25,-9999,-9999
"""


def test_tables_as_pangaea_and_sumup_give_them_are_read(read):
    profile = read(PANGAEA)
    assert_allclose(profile.depth_m, [0.05, 0.15])
    assert_allclose(profile.density_kg_m3, [310, 420])
    profile = read(SUMUP, depth_unit="m")
    assert_allclose(profile.depth_m, [0.05, 0.15, 0.25])
    assert_allclose(profile.thickness_m, 0.1)
    assert_allclose(profile.density_kg_m3, [310, np.nan, 420])


@pytest.mark.parametrize(
    "header",
    [
        "depth_m_we",
        "Depth w.e. [m]",
        "depth (m w.eq.)",
        "depth_mwe",
        "water depth [m]",
        "Depth water equiv [m w.e.]",
        "Depth_mweq",
        "depth.we",
        "depth_mmwe",
        "SWE depth (mm)",
        "Depth [m H2O]",
        "depthWaterEquivalent_m",
        "Depth (kg m-2)",
        "depth m.w.eqv.",
        "Depth ice equiv [m]",
        "depth (m i.e.)",
    ],
)
def test_depth_in_water_equivalent_is_no_depth_in_snow(read, header):
    rows = "\n0.016,310\n0.052,420\n"
    for how in ({}, {"depth_column": header}):
        with refusal(r"water equivalent"):
            read(f"{header},density{rows}", **how)
    # Beside a depth in snow it is passed over; its unit may stand in a row below the header.
    beside = f"depth [m],{header},density\n0.05,0.016,310\n0.15,0.052,420\n"
    assert_allclose(read(beside).depth_m, [0.05, 0.15])
    with refusal("expected depth in snow, found water equivalent"):
        read(f"depth,density\nm w.e.,kg m-3{rows}")


def test_samples_reach_from_their_top_to_the_next(read):
    profile = read("depth_cm,density_kgm3\n0,300\n10,310\n30,400\n80,350")
    assert_allclose(profile.depth_m + profile.thickness_m / 2, [0.1, 0.3, 0.8, 1.3])


def test_a_real_core_of_summit_is_read(shared_data):
    profile = read_profile(shared_data / "snow_radar/cores/summit/summit_density_top10m.csv")
    assert profile.depth_m[0] == 0.055
    assert np.median(profile.density_kg_m3) == pytest.approx(420, abs=40)
    assert "depth in m, density in kg m-3" in profile.note
    assert len(snow_of(profile).depth_m) == profile.depth_m.size


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "table: expected text with a header"),
        ("depth_cm,hardness\n5,310", "density: expected one column .* found depth_cm, hardness"),
        ("depth_cm,density_a,density_b\n5,1,2", "density: expected one column .*--density-column"),
        ("depth,density\n5,310", "depth: expected m, cm, mm in the header, or --depth-unit"),
        ("depth_m,density_lb\n.5,20", "density_lb: expected kg m-3, g cm-3 in the header, or --d"),
        ("depth_m,density\n5,soft", "density: expected numbers, found 'soft' in row 1"),
        (
            "depth_m,density\n0,310\n2,310\n1,320",
            r"depth_m must increase: extents must be finite, above 0, got -1 at \(1,\)",
        ),
        ("depth_cm,density\n10,310\n20,320", "expected top, bottom, middle in the header, or --d"),
        (
            "top_cm,bottom_cm,density\n0,10,310\n5,20,320",
            "samples must not overlap: distances must .* got -0.05 at",
        ),
        ("depth_m,density\n0,05,310\n0,15,420", "rows: expected as many fields as the header has"),
        (
            "depth_m,density\n1,0\n3,310",
            "density_kg_m3 must be finite, at least 1, .* got 0 at",
        ),
    ],
)
def test_bad_pits_end_in_one_line_that_names_the_file(tmp_path, capsys, text, message):
    (tmp_path / "pit.csv").write_text(text)
    pit = str(tmp_path / "pit.csv")
    with pytest.raises(SystemExit) as end:
        cli.main(["simulate", str(tmp_path / "a.nc"), "--profile", pit])
    assert end.value.code == 1
    _, err = capsys.readouterr()
    assert err.startswith(f"error: {pit}: ")
    assert err.count("\n") == 1
    assert re.search(message, err), err


@pytest.mark.parametrize(
    "options",
    [{"depth_unit": "m"}, {"density_unit": "g cm-3"}, {"depth_of": "bottom"}],
)
def test_options_that_contradict_the_header_are_refused(read, options):
    with refusal("as the header says"):
        read("top_cm,density_kgm3\n0,310\n10,320", **options)
    # Anything else was taken for bottoms.
    with refusal("depth_of must be one of top, bottom, middle, got 'tops'"):
        read("depth_cm,density_kgm3\n0,310\n10,320", depth_of="tops")


def test_a_missing_top_and_gaps_are_told_of_and_hold_no_layer(read):
    rows = [f"{10 * n},{10 * n + 10},{300 + 40 * (n % 2)}" for n in range(3, 40)]
    rows[3] = "60,70,"
    profile = read("\n".join(["top_cm,bottom_cm,density_kgm3", *rows[:10], *rows[20:]]))
    told = "above 0.3 m the first one is taken.* over 1.1 m it is bridged"
    with pytest.warns(UserWarning, match=told):
        snow = snow_of(profile)
    _, layers = snowsim.simulate(snow, "snow-2-8", n_range_lines=2, rng=1)
    depth_m = layers["depth_m"].values[:, 0]
    for above_m, below_m in ((0, 0.4), (0.6, 0.7), (1.3, 2.3)):
        assert not ((depth_m > above_m + 1e-6) & (depth_m < below_m - 1e-6)).any()
    # The others are there: 20 below the surface bound measured samples.
    assert len(depth_m) == 1 + 2 + 5 + 16
    assert (layers["power_db"] > -60).all()


def test_samples_reach_half_way_to_their_neighbours_and_the_last_goes_on():
    snow = Snowpack.from_profile([0.1, 0.2, 0.4], [300, 350, 400])
    assert_allclose(snow.depth_m[:, 0], [0, 0.15, 0.3])
    assert_allclose(snow.density_kg_m3[:, 0], [300, 350, 400])
    assert snow.coherent


@pytest.mark.parametrize(
    ("depth_m", "density", "message"),
    [
        ([0.1, 0.3], [np.nan, np.nan], "some density known, got .* with 0 densities"),
        ([0.1, 0.3], [300], r"one value a sample, .* got shapes \(1,\), \(2,\)"),
    ],
)
def test_what_is_no_profile_is_refused_in_one_line(depth_m, density, message):
    with refusal(message):
        Snowpack.from_profile(depth_m, density)


def test_the_command_simulates_a_pit_and_warns_in_one_line(tmp_path):
    pit = "depth_cm,density_kg_m3\n2.5,300\n7.5,320\n12.5,\n17.5,340"
    (tmp_path / "pit.csv").write_text(pit)
    asked = [str(tmp_path / "a.nc"), "--profile", str(tmp_path / "pit.csv"), "--range-lines", "4"]
    done = CliRunner().invoke(cli.simulate, asked)
    assert done.exit_code == 0
    assert "4 samples down to 0.175 m, 1 missing" in done.output
    [warning] = re.findall("^warning: .*", done.output, re.MULTILINE)
    assert "over 0.05 m it is bridged" in warning
    assert read_dataset(tmp_path / "a.nc").sizes["slow_time"] == 4
    refused = CliRunner().invoke(cli.simulate, [*asked[:1], "--force", "--depth-unit", "m"])
    assert "--depth-unit is of a --profile" in refused.output
