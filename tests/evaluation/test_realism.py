from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import yaml
from numpy.testing import assert_allclose

from evaluation.lib import pictures, realism, realism_firn, realism_sides, realism_snow, two_sample
from evaluation.lib.pictures import (
    BINS_PER_ROW,
    PRODUCT_ROW_S,
    Picture,
    means_100m,
    response_picture,
)
from evaluation.lib.realism_table import interval, realism_table, summary
from lib.imports import ROOT
from snowsim.reference import checked_settings

RECORD = ROOT / "workflow/evaluation/lib/real_snow_radar.csv"
KNOWN = yaml.safe_load((ROOT / "workflow/evaluation/lib/realism_rows.yaml").read_text())
ROW_S = 2.886e-10


@pytest.fixture(scope="module")
def real_snow_radar(shared_data):
    folder = shared_data / "snow_radar"
    if not folder.is_dir():
        pytest.skip(f"no real Snow Radar: {folder} is no folder")
    return folder


def speckle_picture(rng, *, gain_db=0.0, band_db=0.0, n_rows=200, n_lines=4000, surface=150):
    """Noise of 5 looks, 30 dB stronger below a surface; gain from line to line, bands of rows."""
    power_db = 10 * np.log10(rng.gamma(5, 1 / 5, (n_rows, n_lines)))
    of_lines_db = gain_db * rng.standard_normal(n_lines)
    of_rows_db = band_db * rng.standard_normal((n_rows, 1))
    power_db += of_lines_db + of_rows_db
    power_db[surface:] += 30
    return Picture(power_db, ROW_S, np.full(n_lines, surface), slice(0, surface - 30))


def test_noise_of_five_looks_and_planted_gain_and_bands_come_back(rng):
    numbers = realism.describe_air(speckle_picture(rng))
    # 480,000 pixels: 4 standard errors of looks are about 4 * 5 * sqrt(3 / 480,000) = 0.05,
    # trigamma(5) gives 2.043 dB.
    assert_allclose(numbers["air, looks"], 5, atol=0.05)
    assert_allclose(numbers["air, s.d."], 2.043, rtol=0.01)
    correlation = numbers["air, autocorrelation along track at 1 lines"]
    assert abs(correlation) < 4 / np.sqrt(480_000)
    numbers = realism.describe_air(speckle_picture(rng, gain_db=0.3, band_db=0.1))
    # The running mean of 31 lines takes 1/31 of the variance; 4000 lines know the rest to 4 %, 120
    # rows to 26 %.
    assert_allclose(numbers["air, gain from line to line"], 0.3 * np.sqrt(30 / 31), rtol=0.04)
    assert_allclose(numbers["air, power from row to row"], 0.1, rtol=0.26)
    # Without them, halves of 60 rows and 4000 lines share nothing: 2.04 / sqrt(60 sqrt(4000)) dB
    # are left to chance.
    numbers = realism.describe_air(speckle_picture(rng))
    assert numbers["air, gain from line to line"] < 2 * 2.04 / np.sqrt(60 * 63)


def test_a_planted_sidelobe_a_rough_surface_and_homogeneous_snow_between_layers(rng):
    picture = speckle_picture(rng)
    rows_above = 4e-9 / ROW_S
    power = 10 ** (picture.power_db / 10)
    power[150 - round(rows_above)] += 10 ** (2.0 * 0.8)  # 14 dB below the surface
    made = Picture(10 * np.log10(power), ROW_S, picture.surface_row, picture.air)
    share = rows_above - round(rows_above)  # between rows on a straight line
    level = realism.describe_sidelobes(made)["sidelobes, level before the surface at 4 ns"]
    # Surface and sidelobe are means over 4000 lines of 5 looks: 4 standard errors are 0.12 dB.
    assert_allclose(level, -14 + 10 * np.log10(1 - abs(share)), atol=0.12)
    rough_surface = 150 + rng.integers(-20, 20, 4000)
    rough = Picture(made.power_db, ROW_S, rough_surface, made.air)
    assert realism.describe_sidelobes(rough) == {}
    picture = speckle_picture(rng, n_rows=300)
    picture.power_db[150 + 30 : 150 + 40] += 3
    row_db = realism.homogeneous_snow(picture).mean(axis=1)
    assert abs(row_db - 29.6).max() < 0.5  # 30 dB less 0.45 of the mean of decibels
    numbers = realism.describe_snow(picture)
    assert_allclose(numbers["snow, s.d."], 2.043, rtol=0.02)


def test_decay_and_smoothness_of_planted_100_m_means(rng):
    depth_m = np.arange(45) * BINS_PER_ROW * 0.0433
    sag = np.linspace(0, 2, 50)  # rows over 50 columns: 0.0408 rows a column
    layers = np.cos(2 * np.pi * (np.arange(45)[:, None] - sag) / 6)
    falling_db = -0.3 * depth_m[:, None] + np.zeros(50)
    found = realism.describe_decay(falling_db, 0.0433)
    assert_allclose(found["Greenland, decay of bins 50 to 650"], -0.3, rtol=1e-9)
    assert_allclose(found["Greenland, ratio of the two stages of decay"], 1, rtol=1e-9)
    assert np.isnan(found["Greenland, decay of bins 2000 to 4000"])
    numbers = realism.describe_means(layers)
    # 36 rows are 6 periods, of which a cubic takes a little.
    assert_allclose(numbers["Greenland, texture s.d."], np.sqrt(0.5), rtol=0.03)
    # A window of 12 rows is two periods; its ends, not shifted with it, pull the peak of the
    # correlation by per cents.
    for lag in (5, 10):
        shift = numbers[f"Greenland, shift of layers at {100 * lag} m"]
        assert_allclose(shift, BINS_PER_ROW * lag * 2 / 49, rtol=0.3)


def test_means_over_100_m_are_taken_of_decibels_from_the_surface_on():
    surface_row = np.array([100, 103] * 50)
    power_db = -(np.arange(400)[:, None] - surface_row) * 0.1 + np.zeros(100)
    picture = Picture(power_db, PRODUCT_ROW_S, surface_row, slice(0, 50))
    means = means_100m(picture, 5.0)
    assert means.shape == (18, 5)
    # Three samples, five bins apart, from the surface on.
    assert_allclose(means[0], -0.1 * 5, rtol=1e-12)
    assert_allclose(means[10], -0.1 * 5 * (32 + 1), rtol=1e-12)


def test_the_response_has_the_autocorrelation_of_its_window(rng):
    radar = checked_settings({}).radar
    numbers = realism.describe_response(response_picture(radar, rng=rng, n_lines=2000))
    # White noise under a Hann window in frequency: intensity correlates as the square of the
    # transform of its square.
    frequency = (np.arange(4000) + 0.5) / 4000
    density = np.sin(np.pi * frequency) ** 4
    bandwidth_ghz = radar.bandwidth_hz / radar.response_widening * 1e-9
    for delay_ns in (0.1, 0.3):
        phase = 2 * np.pi * (frequency - 0.5) * delay_ns * bandwidth_ghz
        expected = np.average(np.cos(phase), weights=density) ** 2
        found = numbers[f"air, autocorrelation down at {delay_ns} ns"]
        # Decibels instead of power, and straight lines between rows, cost up to 0.03.
        assert_allclose(found, expected, atol=0.03)


def test_cores_of_planted_anomalies_and_ratios_of_thickness_come_back(rng):
    years = rng.standard_normal(20_000)
    series = 0.4 * (1 + 0.2 * years) + 1e-6 * np.arange(20_000)
    found = realism_snow.describe_core(series)
    deviation = found["cores, deviation from year to year"]
    assert_allclose(deviation, 0.2 * 0.4 / series.mean(), rtol=4 / np.sqrt(40_000))
    with_next = found["cores, correlation of one year with the next"]
    assert abs(with_next) < 4 / np.sqrt(20_000)
    other_years = 0.6 * years + 0.8 * rng.standard_normal(20_000)
    other = 0.4 * (1 + 0.2 * other_years)
    between = realism_snow.neighbour_correlations([series, other])
    assert_allclose(between, [0.6], atol=4 * 0.64 / np.sqrt(20_000))
    # 28 and 84 px of a mean of 56.
    thin = np.array([[5.0], [8.0], [8.0]])
    thick = np.array([[15.0], [12.0], [12.0]])
    slabs = [thin, thick]
    assert realism_snow.thickness_ratio(slabs, (22, 40)) == 1.6
    assert realism_snow.thickness_ratio(slabs, (80, 100)) == 0.8
    assert np.isnan(realism_snow.thickness_ratio(slabs, (40, 60)))


def test_scenes_without_a_slab_leave_rows_with_a_reason(rng):
    assert np.isnan(realism_snow.thickness_ratio([], (22, 40)))
    assert np.isnan(realism_snow.spacing_variation([]))
    found = realism_sides.describe_thickness([], rng=rng)
    nothing = pd.DataFrame(columns=["quantity", "frame", "value"])
    table = realism_table(found, nothing, KNOWN)
    of_thickness = table[table["quantity"].isin(found)]
    assert set(of_thickness["reason"]) == {"no such value in the flight"}


def test_power_by_depth_is_that_planted_and_nan_beyond_the_data():
    surface = 60
    ends_s = realism_firn.site_delay_s(np.array(realism_firn.DEPTHS_M))
    below_s = (np.arange(500) - surface) * ROW_S
    power = np.full(500, 1e-4)
    power[surface] += 1
    power[(below_s >= ends_s[1, 0]) & (below_s < ends_s[1, 1])] += 0.02
    power_db = np.tile(10 * np.log10(power)[:, None], 40)
    picture = Picture(power_db, ROW_S, np.full(40, surface), slice(0, 40))
    found = list(realism_firn.describe_power(picture).values())
    # The ends fall within a row of 47: at most 2 % of 0.02.
    assert_allclose(found[1], 10 * np.log10(0.02), atol=0.2)
    assert np.isnan(found[0])
    assert np.isnan(found[3])


def test_slabs_of_random_walks_grow_with_the_lag_and_share_what_was_planted(rng):
    walks = np.cumsum(rng.standard_normal((200, 256)), axis=1)
    found = realism_firn.describe_slabs([walk[None] for walk in walks])
    units, statistic = found[realism_firn.GROWTH]
    # 200 walks, a handful of independent differences each at the longest lag.
    assert_allclose(statistic(units), 1, atol=0.15)
    shared = rng.standard_normal((1, 256 * 64))
    own = rng.standard_normal((8, 256 * 64))
    sums = [realism_firn.shared_power(0.6**0.5 * shared + 0.4**0.5 * own, (16, 64))]
    assert_allclose(realism_firn.correlation_of(sums), 0.6, atol=0.05)
    assert np.isnan(realism_firn.correlation_of([realism_firn.shared_power(own[:, :99], (16, 64))]))


def test_steps_between_cells_are_those_of_white_layers(rng):
    depth_m = np.arange(0.0005, 20, 0.001)
    cell = (depth_m / realism_firn.cell_m()).astype(int)
    density = 400 + 20 * rng.standard_normal(cell[-1] + 1)[cell]
    # Neighbours differ by sqrt(2) of the s.d.; 120 and 260 cells know it to 7 and 5 %.
    assert_allclose(realism_firn.cell_steps(depth_m, density), 20 * np.sqrt(2), rtol=0.25)


def test_a_classifier_is_at_chance_between_equals_and_right_where_texture_differs(rng):
    def frames(deviation):
        return [[deviation * rng.standard_normal((32, 32)) for _ in range(100)] for _ in range(4)]

    same, low, high = two_sample.accuracy_of_crops(frames(1), frames(1), rng=rng)
    # 800 decisions: 4 standard errors are 0.07.
    assert abs(same - 0.5) < 0.07
    assert low < same < high
    different, _, _ = two_sample.accuracy_of_crops(frames(1), frames(1.5), rng=rng)
    assert different > 0.98
    of_one_frame, _, _ = two_sample.accuracy_of_crops([frames(1)[0]], frames(1), rng=rng)
    assert np.isnan(of_one_frame)


def test_rows_agree_by_what_real_frames_differ_or_the_interval(rng):
    real = pd.DataFrame(
        [("air, s.d.", "a", 2.0), ("air, s.d.", "b", 2.2), ("snow, s.d.", "a", 2.0)],
        columns=["quantity", "frame", "value"],
    )
    found = {(2.29, 2.28, 2.3): "yes", (2.31, 2.3, 2.32): "no", (2.31, 2.2, 2.45): "yes"}
    for value_and_interval, agrees in found.items():
        table = realism_table({"air, s.d.": value_and_interval}, real, KNOWN)
        table = table.set_index("quantity")
        assert table.loc["air, s.d.", "agrees"] == agrees
    assert table.loc["snow, s.d.", "reason"] == "no such value in the flight"
    assert summary(table) == "1 quantities comparable, 1 agree (100%)"
    without_reason = table["reason"] == ""
    assert (table["comparable"] == without_reason).all()
    assert_allclose(interval([1.0, np.nan, 1.0], rng=rng), 1)


def test_the_record_is_what_the_real_files_give(real_snow_radar):
    _, record = realism_sides.without_flight(pd.read_csv(RECORD))
    measured, crops = realism_sides.describe_real(real_snow_radar)
    of_frames = record[record["frame"] != realism_sides.DECIDED[3]]
    suffixes = ("_recorded", "_computed")
    both = of_frames.merge(measured, on=["quantity", "frame"], suffixes=suffixes)
    assert len(both) == len(measured)
    # Written with 10 digits.
    assert_allclose(both["value_computed"], both["value_recorded"], rtol=1e-8, atol=1e-9)
    assert {kind for frame in crops for kind in frame} == set(two_sample.KINDS)


def test_real_frames_measure_what_is_printed_of_them(real_snow_radar):
    measured, _ = realism_sides.describe_real(real_snow_radar)
    value = measured.set_index(["quantity", "frame"])["value"]
    # Published of the same pictures: s.d. 2.1 dB, looks 4.6-4.7; of the cores: 0.17 at Summit,
    # neighbours 0.43-0.86.
    assert value["air, s.d."].round(1).tolist() == [2.1, 2.1]
    assert value["air, looks"].round(1).tolist() == [4.6, 4.6]
    assert round(value["cores, deviation from year to year", "Summit"], 2) == 0.17
    neighbours = value["cores, correlation of neighbours"]
    assert round(neighbours.min(), 2) == 0.44
    assert round(neighbours.max(), 2) == 0.86


def test_core_b26_has_the_power_by_depth_of_its_first_order_response(real_snow_radar):
    core = pictures.read_core_b26(real_snow_radar)
    with pytest.warns(UserWarning, match="density is missing over 4.96 of 39.98 m"):
        snow = realism_firn.core_snowpack(*core, slope=1e-5, roughness_m=0.0)
    # A plane wave and the window's own response.
    radar = replace(realism_firn.RADAR, height_m=1e6, widening=1.0)
    found = realism_firn.power_by_depth(snow, radar)
    # Computed once elsewhere, of the same sweep and window, in half of these depths.
    assert_allclose(found[:3], [-17, -18, -24], atol=2)
