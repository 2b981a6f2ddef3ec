"""Flights of the study: drawn within their ranges, alike but for that, and scored over flights."""

import numpy as np
import pandas as pd
from edge_counts import image_counts
from numpy.testing import assert_allclose
from runs import CONFIG
from scipy.stats import ttest_1samp

from evaluation.lib import flights
from evaluation.lib.flight_scores import PAIRS, mean_over_flights, training_scores, worth_table
from reference import checked_settings


def test_flights_lie_within_the_stated_ranges_and_are_flights_that_can_be_flown():
    for flight in flights.flights_of(2000, 20):
        drawn = flights.draw_reference(CONFIG["reference"], int(flight))
        checked_settings(drawn)
        for group, ranges in flights.RANGES.items():
            for name, (low, high) in ranges.items():
                assert low <= drawn[group][name] <= high, (group, name)


def test_flights_differ_in_seed_climate_and_radar_alone():
    first, second = (
        flights.flight_config(CONFIG, "flights", flight) for flight in ("2000", "2001")
    )
    assert (first["seed"], second["seed"]) == (2000, 2001)
    assert first["reference"]["climate"] != second["reference"]["climate"]
    assert first["reference"]["radar"] != second["reference"]["radar"]
    assert first["tracker"]["n_seeds"] == CONFIG["studies"]["flights"]["n_trainings"]
    for own in (first, second):
        assert own["benchmark"].pop("test_seed") == own["seed"]
        del own["seed"], own["reference"]
    assert first == second


def test_draws_of_a_flight_are_those_that_the_published_scores_are_of():
    drawn = flights.draw_reference(CONFIG["reference"], 2000)
    assert drawn["climate"]["accumulation_factor"] == 0.9628
    assert drawn["radar"]["line_gain_sd_db"] == 0.321


def counts_table(share, rng):
    """Edge counts of a training as its table holds them: 30 images, of which a share is found."""
    tables = []
    for number, counts in enumerate(image_counts(share, 30, rng=rng)):
        table = pd.DataFrame({"scene": f"{number:02d}", "threshold": [0.2, 0.5, 0.8], **counts})
        table["grid"] = "quantiles"
        tables.append(table.assign(output="fuse"))
        tables.append(table.assign(output="side_1", matched_truth=0, matched_prediction=0))
    return pd.concat(tables)


def test_the_table_holds_scores_of_the_fused_output_and_their_differences_flight_by_flight(rng):
    sets = sorted({name for pair in PAIRS for name in pair})
    shares = {name: 0.5 + 0.05 * number for number, name in enumerate(sets)}
    trainings = [(name, replica) for name in sets for replica in range(2)]
    scores = []
    for flight in (2000, 2001):
        tables = [counts_table(shares[name], rng) for name, _ in trainings]
        scores.append(training_scores(tables, trainings).assign(flight=flight))
    table = worth_table(pd.concat(scores))
    ods = table[table["metric"] == "ods"].set_index(["training_set", "base"])
    assert tuple(ods.index[0]) == ("rd_pd", "rd")
    for name, base in ods.index:
        row = ods.loc[(name, base), ["flight_2000", "flight_2001"]]
        expected = shares[name] - shares.get(base, 0)
        # Of 6000 trials twice: 0.0045, four of those and what the best of three thresholds adds.
        assert_allclose(row.astype(float), expected, atol=0.04)
    assert len(ods) == len(PAIRS) + len(sets)


def test_the_interval_over_flights_is_student_s_t():
    values = pd.Series([0.01, 0.03, 0.02, 0.00])
    found = mean_over_flights(values)
    expected = ttest_1samp(values, 0).confidence_interval(0.95)
    assert_allclose([found["low"], found["high"]], [expected.low, expected.high], rtol=1e-12)
    assert np.isnan(mean_over_flights(values[:1])["low"])
