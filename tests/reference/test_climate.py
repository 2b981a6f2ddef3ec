import numpy as np
import pytest
from flights import climate_of
from numpy.testing import assert_allclose
from refusals import refusal

from reference import checked_settings
from reference.climate import draw_waves
from reference.line import line_coordinates, line_length_km, place_at
from reference.settings import Settings, check_window
from snowsim.snowpack.along_track import draw_along_track


def test_the_line_is_1200_km_from_central_to_north_west_greenland_and_positions_are_distances():
    assert_allclose(line_length_km(), 1200, rtol=0.02)
    latitude, longitude = line_coordinates(np.linspace(0, line_length_km(), 50))
    assert (np.diff(latitude[:40]) > 0).all()
    assert (np.diff(longitude) < 0).all()
    latitude, longitude = np.radians(line_coordinates(np.array([300.0, 310.0])))
    turn = np.cos(longitude[1] - longitude[0])
    cosine = np.sin(latitude).prod() + np.cos(latitude).prod() * turn
    # Near 1 a cosine of float64 leaves 1e-16 / angle^2 = 1e-10.
    assert_allclose(6371 * np.arccos(cosine), 10, rtol=1e-8)


def test_percolation_is_rare_at_the_low_end_and_accumulation_in_the_range_of_the_ice_sheet(climate):
    positions_km = (np.arange(20) + 0.5) / 20 * line_length_km()
    share = [climate.percolation(place_at(km)) for km in positions_km]
    assert 1 <= np.sum(np.array(share) > 0.5) <= 2
    assert share[-1] > 0.5
    assert max(share[:-2]) < 0.01
    means = [place_at(km).accumulation_m for km in np.linspace(5, line_length_km() - 5, 40)]
    assert 0.13 < min(means) < 0.25
    assert 0.4 < max(means) < 0.75


def test_every_frame_has_the_same_years_and_undulations_stay_in_place_on_a_track(climate, rng):
    def log_accumulation(track, km, n_years=60):
        position_km = km + np.arange(1000) * 5.47e-3
        return np.log(climate.draw_accumulation(track, position_km, n_years, rng=rng))

    one, other = (log_accumulation("flight", km, 30)[1:, :400].mean(axis=1) for km in (500, 504))
    # Drift of 0.1 with a length of 2.5 km, hardly less over means of 2 km, beside anomalies of 0.18
    # leaves a correlation of 0.8; of 29 years it is known to 0.07.
    assert 0.6 < np.corrcoef(one, other)[0, 1] < 0.95
    tracks = ("flight", "flight", "test_0")
    alike = np.corrcoef([log_accumulation(track, 400).mean(axis=0) for track in tracks])
    assert alike[0, 1] > 0.98
    assert abs(alike[0, 2]) < 0.9


def test_relief_does_not_add_up_with_depth(rng):
    still = dict.fromkeys(("anomaly_sd", "undulation_sd", "drift_sd"), 0.0)
    climate = climate_of({"climate": still | {"relief_sd": 0.05}})
    # About the least of the profile along the line: no trend of the mean.
    position_km = 0.7 * line_length_km() + np.arange(-1000, 1000) * 5.47e-3
    water_m = climate.draw_accumulation("flight", position_km, 80, rng=rng)
    spread = np.cumsum(water_m, axis=0).std(axis=1) / water_m.mean()
    # A random walk would be sqrt(79 / 9) = 3 times as rough at the bottom; levelled, only exp's
    # second order grows.
    assert spread[-1] < 1.5 * spread[9]


def test_waves_have_unit_variance_and_series_are_stationary_with_the_correlation_asked_for(rng):
    values = [draw_waves(1, 20, rng=rng)(np.array([0.0, 33.0])) for _ in range(4000)]
    assert_allclose(np.std(values), 1, rtol=4 / np.sqrt(2 * 8000))
    series = draw_along_track(4000, 40, 8.0, rng=rng)
    assert_allclose(series.std(axis=0), 1, rtol=5 / np.sqrt(2 * 4000))
    correlation = (series[:, 5] * series[:, 13]).mean()
    assert_allclose(correlation, np.exp(-1), atol=4 / np.sqrt(4000))


@pytest.mark.parametrize(
    ("reference", "message"),
    [
        ({"firn": {"densty": 3}}, "firn.densty: unknown key"),
        ({"firn": {"fade_depth_m": 0.5}}, "firn.fade_depth_m must be finite, above"),
        ({"radar": {"n_sub_bins": 1}}, "radar.n_sub_bins that sample the sweep must .* at least 1"),
        ({"radar": {"surface_bin": 790}}, "radar.surface_bin with 100 rows below it must .* most"),
    ],
)
def test_settings_out_of_range_are_refused_by_name(reference, message):
    with refusal(message):
        checked_settings(reference)
    check_window(Settings())  # every start of the workflow takes the default's for granted
