"""Pits and cores as people write them, and what a radar sees of them."""

import re

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from numpy.testing import assert_allclose
from refusals import refusal

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
        "depth_cm,density_g_cm3\n5,.31\n15,.42\n25,NaN",
        "# pit\ndepth_m , density_kg_m3\n0.05, 310\n# lunch\n0.15, 420\n, 500",
        "site,depth_m,density_kg_m3,density_error\nA,0.05,310,soft\nA,0.15,420,9\nA,0.25,,9",
        "top_cm,bottom_cm,density_kg_m3\n0,10,310\n10,20,420\n20,30,",
        "top_m,bottom_m,density_g_cm3\n0,.1,.31\n.1,.2,.42\n.2,.3,",
    ],
)
def test_a_pit_is_the_same_in_every_way_that_the_header_may_say_it(read, text):
    profile = read(text)
    assert_allclose(profile.density_kg_m3, [310, 420])
    assert "2 samples from 0.05 to 0.15 m; rows without a number, left out: 1" in profile.note
    snow = snow_of(profile)
    assert_allclose(snow.depth_m[:, 0], [0, 0.1])
    assert_allclose(snow.density_kg_m3[:, 0], [310, 420])


def test_other_columns_may_be_in_any_encoding(read):
    text = "lieu,depth_m,density_kg_m3\névé,0.05,310\nnévé,0.15,420"
    assert_allclose(read(text, encoding="cp1252").depth_m, [0.05, 0.15])


@pytest.mark.parametrize(
    "header",
    [
        "depth,density",
        "depth_m,density",
        "Depth (cm),Density (g/cm^3)",
        "depth_mm,density_kg_m3",
        "depth_m_we,density_kg_m3",
        "top_m,density_kg_m3",
        "top_m,bottom_cm,density_kg_m3",
        "depth_m;density_kg_m3",
        "depth_m\tdensity_kg_m3",
        "depth_m,depth_cm,density_kg_m3",
        "depth_m,top_m,bottom_m,density_kg_m3",
        "depth_m,density_kg_m3,density_g_cm3",
        "depth_m,density_kg_m3,density_kg_m3",
        "depth_m,rho_kgm3",
    ],
)
def test_any_other_header_is_refused_by_one_that_is_read(read, header):
    accepted = "depth_m or depth_cm .* top_m and bottom_m, .* and with density_kg_m3 or density_g"
    row = re.sub("[^,;\t]+", "1", header)
    with refusal(f"header: expected a header, .*{accepted}"):
        read(f"{header}\n{row}\n")


def test_a_real_core_of_summit_is_read_once_its_column_is_renamed(shared_data, tmp_path):
    published = shared_data / "snow_radar/cores/summit/summit_density_top10m.csv"
    with refusal("header: expected .* found depth_m, rho_kgm3"):
        read_profile(published)
    renamed = pd.read_csv(published).rename(columns={"rho_kgm3": "density_kg_m3"})
    renamed.to_csv(tmp_path / "summit.csv", index=False)
    profile = read_profile(tmp_path / "summit.csv")
    assert profile.depth_m[0] == 0.055
    assert np.median(profile.density_kg_m3) == pytest.approx(420, abs=40)
    assert len(snow_of(profile).depth_m) == profile.depth_m.size


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "table: expected text with a header"),
        ("depth_cm,hardness\n5,310", "header: expected .* found depth_cm, hardness"),
        ("depth_m,density_kg_m3\n", "rows: expected some with a depth and a density, found none"),
        (
            "depth_m,density_kg_m3\n5,soft",
            "density_kg_m3: expected numbers, found 'soft' in row 1",
        ),
        (
            "depth_m,density_kg_m3\n0,310\n2,310\n1,320",
            r"depth_m must increase: its steps must be finite, above 0, got -1 at \(1,\)",
        ),
        ("depth_m,density_kg_m3\n-1,310\n2,310", "depth_m must be finite, at least 0, got -1"),
        ("depth_m,density_kg_m3\n1,inf\n2,310", "density_kg_m3 must be finite, got inf"),
        (
            "top_cm,bottom_cm,density_kg_m3\n0,10,310\n5,20,320",
            "samples must not overlap: distances must .* got -0.05 at",
        ),
        ("top_cm,bottom_cm,density_kg_m3\n0,10,310\n20,10,320", "thickness_m must be .* above 0"),
        ("depth_m,density_kg_m3\n0,05,310\n0,15,420", "rows: expected as many fields"),
        (
            "depth_m,density_kg_m3\n1,0\n3,310",
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


def test_samples_beside_a_gap_reach_half_way_to_each_other(read):
    """A row left out, rows that are missing, and snow above the first sample."""
    rows = ["10,20,300", "20,30,", "30,40,350", "60,80,400"]
    profile = read("\n".join(["top_cm,bottom_cm,density_kg_m3", *rows]))
    snow = snow_of(profile)
    assert_allclose(snow.depth_m[:, 0], [0, 0.25, 0.5])
    assert_allclose(snow.density_kg_m3[:, 0], [300, 350, 400])
    assert "3 samples from 0.15 to 0.7 m; rows without a number, left out: 1" in profile.note


def test_samples_reach_half_way_to_their_neighbours_and_the_last_goes_on():
    snow = Snowpack.from_profile([0.1, 0.2, 0.4], [300, 350, 400])
    assert_allclose(snow.depth_m[:, 0], [0, 0.15, 0.3])
    assert_allclose(snow.density_kg_m3[:, 0], [300, 350, 400])
    assert snow.coherent


@pytest.mark.parametrize(
    ("depth_m", "density", "message"),
    [
        ([0.1, 0.3], [300, np.nan], r"density_kg_m3 must be finite, got nan at \(1,\)"),
        ([0.1, 0.3], [300], r"one value a sample, got shapes \(2,\), \(1,\)"),
    ],
)
def test_what_is_no_profile_is_refused_in_one_line(depth_m, density, message):
    with refusal(message):
        Snowpack.from_profile(depth_m, density)


def test_the_command_simulates_a_pit_and_counts_rows_left_out(tmp_path):
    pit = "depth_cm,density_kg_m3\n2.5,300\n7.5,320\n12.5,\n17.5,340"
    (tmp_path / "pit.csv").write_text(pit)
    asked = [str(tmp_path / "a.nc"), "--profile", str(tmp_path / "pit.csv"), "--range-lines", "4"]
    done = CliRunner().invoke(cli.simulate, asked)
    assert done.exit_code == 0
    assert "3 samples from 0.025 to 0.175 m; rows without a number, left out: 1" in done.output
    assert read_dataset(tmp_path / "a.nc").sizes["slow_time"] == 4
    refused = CliRunner().invoke(cli.simulate, [*asked, "--force", "--years", "3"])
    assert "--years is of a climate, not of a --profile" in refused.output
