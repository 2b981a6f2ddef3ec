"""Flights of the study: drawn within their ranges, alike but for that, and scored over flights."""

import numpy as np
import pandas as pd
import pytest
import yaml
from configuration import CONFIG
from edge_counts import image_counts
from numpy.testing import assert_allclose
from scipy.stats import t as student

from evaluation.lib import flights
from evaluation.lib.flight_scores import (
    PAIRS,
    curve_table,
    mean_over_flights,
    scenes_for,
    scenes_saved,
)
from lib.configuration import filled
from snowsim.metrics.comparison import METRICS, replica_scores
from snowsim.metrics.edges import stack_counts
from snowsim.reference import checked_settings


@pytest.fixture
def config():
    given = yaml.safe_load(CONFIG.read_text())
    return given | filled(given)


def test_flights_lie_within_the_stated_ranges_and_are_flights_that_can_be_flown(config):
    for flight in flights.flights_of({"n_flights": 20}):
        drawn = flights.draw_reference(config["reference"], int(flight))
        checked_settings(drawn)
        row = flights.drawn_rows(drawn, flight)
        for group, ranges in flights.RANGES.items():
            for name, (low, high) in ranges.items():
                assert low <= row[name] <= high, (group, name)


def test_every_range_holds_the_default_and_is_that_of_a_setting(config):
    for group, ranges in flights.RANGES.items():
        for name, (low, high) in ranges.items():
            assert low < config["reference"].get(group, {}).get(name, (low + high) / 2) < high


def test_flights_differ_in_seed_climate_and_radar_alone(config):
    first, second = (flights.flight_config(config, flight) for flight in ("2000", "2001"))
    assert (first["seed"], second["seed"]) == (2000, 2001)
    assert first["reference"]["climate"] != second["reference"]["climate"]
    assert first["reference"]["radar"] != second["reference"]["radar"]
    for own in (first, second):
        del own["seed"], own["reference"]
    assert first == second
    config["studies"]["flights"]["n_curve_flights"] = 1
    assert flights.flight_config(config, "2001")["studies"]["flights"]["curve"] == [120]


def test_a_curve_beyond_the_train_scenes_is_refused_in_one_line():
    with pytest.raises(ValueError, match=r"at most benchmark\.n_scenes\.train = 20, got 30$"):
        flights.check_curve({"curve": [4, 30]}, 20)


def test_few_scenes_that_hold_too_little_leave_real_ones_to_train_on(tmp_path):
    study = {"curve": [4, 8], "n_trainings": 2}
    for n, radiometry in ((4, "refused"), (8, "constant")):
        text = f"n_scenes,radiometry,reason\n{n},{radiometry},\n"
        (tmp_path / f"{n}.csv").write_text(text)
    runs = dict(flights.few_runs(sorted(tmp_path.glob("*.csv")), study))
    assert set(runs) == {"rd_of_4", "rd_of_8", "pd_of_8", "rd_pd_of_8"}
    # What is drawn from few scenes is all that is added to them.
    few = flights.few_of(study)
    assert few["rd_of_4"].drawn_files(["0000"]) == few["pd_of_4"].real_files() == []
    files = [*few["rd_pd_of_4"].real_files(), *few["rd_pd_of_4"].drawn_files(["0000"])]
    assert all(file.startswith("results/one_flight/few/4/") for file in files)
    assert {name for pair in PAIRS for name in pair} <= set(dict(flights.whole_runs(study)))


def drawn_runs(shares, rng):
    """Stacked counts of two trainings of every run of a curve, by the share that each finds."""
    runs = {}
    for name, share in shares.items():
        runs[name] = [stack_counts(image_counts(share, 30, rng=rng)) for _ in range(2)]
    return runs


def test_the_table_of_a_curve_has_intervals_and_leaves_open_what_could_not_be_drawn(rng):
    shares = {"rd_of_4": 0.5, "rd_of_8": 0.7, "pd_of_8": 0.6, "rd_pd_of_8": 0.8}
    few = pd.DataFrame({"n_scenes": [4, 8], "radiometry": ["refused", "measured"]})
    runs = drawn_runs(shares | {"universal": 0.6}, rng)
    table = curve_table("2000", runs, few, n_bootstrap=50, rng=rng)
    rows = table.set_index(["training_set", "n_scenes"])
    for name, share in shares.items():
        training_set, n = name.split("_of_")
        row = rows.loc[training_set, int(n)]
        # Of 6000 trials twice: 0.0045, four of those and what the best of three thresholds adds.
        assert_allclose(row["ods"], share, atol=0.03)
        assert row["low"] < row["ods"] < row["high"]
    assert rows.loc["pd", 4][["ods", "low", "saved", "saved_high"]].isna().all()
    # 0.6 lies halfway between RD's scores of 4 and 8 scenes.
    assert_allclose(rows.loc["pd", 8]["saved"], np.sqrt(4 * 8) - 8, atol=0.8)
    assert rows.loc["rd_pd", 8]["saved"] == np.inf
    # The tracker that was trained on nothing of the flight saves all of them.
    assert_allclose(rows.loc["universal", 0]["saved"], np.sqrt(4 * 8), atol=0.8)
    assert list(table["training_set"]).count("universal") == 1


def test_the_interval_over_flights_is_student_s_t():
    differences = np.array([0.01, 0.03, 0.02, 0.00])
    result = mean_over_flights(differences)
    error = differences.std(ddof=1) / 2
    assert_allclose(result["high"] - result["difference"], student.ppf(0.975, 3) * error)
    assert_allclose(result["p_value"], 2 * student.sf(0.015 / error, 3))
    assert np.isnan(mean_over_flights([0.01])["low"])
    assert mean_over_flights([0.0, 0.0])["p_value"] == 1


def drawn_images(shift, n_images, rng):
    """Stacked counts of a tracker: of `n_images`, few of which hold most pixels, 5 thresholds."""
    n_truth = np.maximum(rng.lognormal(6, 1, n_images), 20).astype(int)[:, None]
    found = 1 / (1 + np.exp(-shift[:, None] - np.linspace(2, 0, 5)))
    right = 1 / (1 + np.exp(-shift[:, None] - np.linspace(0, 2, 5)))
    matched = rng.binomial(n_truth, found)
    n_prediction = np.maximum((matched / right).astype(int), matched)
    n_truth = np.broadcast_to(n_truth, matched.shape)
    counts = {"matched_truth": matched, "n_truth": n_truth}
    return counts | {"matched_prediction": matched, "n_prediction": n_prediction}


def flight_difference(worth, n_images, n_replicas, *, rng):
    """Difference of fused ODS on one simulated flight, a generator and some trainings."""
    image = rng.normal(0, 0.6, n_images)
    of_image = worth + rng.normal(0, 0.3, n_images)  # what drawn scenes are worth on each image
    of_flight = rng.normal(0, 0.08)
    of_generator = rng.normal(0, 0.05)
    scores = []
    for effect in (0, of_image + of_flight + of_generator):
        replicas = []
        for _ in range(n_replicas):
            shift = image + effect + rng.normal(0, 0.05)
            replicas.append(drawn_images(shift, n_images, rng))
        scores.append(replica_scores(replicas)[:, METRICS.index("ods")].mean())
    return scores[1] - scores[0]


def test_the_interval_over_flights_covers_what_drawn_scenes_are_worth(rng):
    # Six flights of 60 images and three trainings, as the study has by default.
    n_studies, n_flights = 500, 6
    simulated = [flight_difference(0.15, 60, 3, rng=rng) for _ in range(n_studies * n_flights)]
    # The mean of all stands for the truth: it errs by 1 / sqrt(500) of what one study does, which
    # costs less than .001 of coverage.
    truth = np.mean(simulated)
    studies = [mean_over_flights(drawn) for drawn in np.reshape(simulated, (n_studies, n_flights))]
    covered = np.mean([study["low"] <= truth <= study["high"] for study in studies])
    # .95, known to .0097 by 500 studies.
    assert 0.90 < covered < 0.98


def test_scenes_saved_are_the_distance_between_the_curves():
    numbers = [4, 8, 16]
    real = [0.5, 0.6, 0.7]
    assert_allclose(scenes_for(0.65, numbers, real), np.sqrt(8 * 16))
    assert scenes_for(0.4, numbers, real) == 4
    assert scenes_for(0.8, numbers, real) == np.inf
    # A dip counts as chance: both of its ends are taken for 0.65.
    assert_allclose(scenes_for(0.575, numbers, [0.5, 0.7, 0.6]), np.sqrt(4 * 8))
    assert scenes_for(0.68, numbers, [0.5, 0.7, 0.6]) == np.inf
    curves = np.array([real, [0.6, 0.7, 0.7], [0.7, 0.7, 0.8], [0.6, 0.6, 0.6]])
    expected = [[np.nan] * 3, [4, 8, 0], [12, 8, np.inf], [8, 8, 8]]
    # Rounding of a logarithm and back: some eps of 16.
    assert_allclose(scenes_saved(curves, numbers), expected, atol=1e-13)
