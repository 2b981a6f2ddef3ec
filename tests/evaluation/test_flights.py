"""Flights of the study: drawn within their ranges, alike but for that, and scored over flights."""

import numpy as np
import pandas as pd
from numpy.testing import assert_allclose
from runs import CONFIG
from scipy.stats import ttest_1samp

from evaluation.lib import flights
from evaluation.lib.flight_scores import (
    ROLES,
    found_by_depth,
    holm,
    mean_over_flights,
    share_of_deep,
    worth_table,
)
from reference import checked_settings
from snowsim.metrics.edges import METRICS


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
    for own in (first, second):
        assert own["benchmark"].pop("test_seed") == own["seed"]
        del own["seed"], own["reference"]
    assert first == second


def test_a_study_names_its_scenes_and_may_take_the_default_flight():
    default = flights.flight_config(CONFIG, "annotation", str(CONFIG["seed"]))
    for name in ("seed", "reference"):
        assert default[name] == CONFIG[name]
    assert default["benchmark"]["n_scenes"]["train"] == 240
    assert default["benchmark"]["test_seed"] == CONFIG["benchmark"]["test_seed"]


def test_draws_of_a_flight_are_those_that_the_published_scores_are_of():
    drawn = flights.draw_reference(CONFIG["reference"], 2000)
    assert drawn["climate"]["accumulation_factor"] == 0.9628
    assert drawn["radar"]["line_gain_sd_db"] == 0.321


def scores_of(levels, flights=(4000, 4001, 4002), n_trainings=2):
    """Scores of trainings on sets with these levels, which scatter by training and by flight."""
    rng = np.random.default_rng(1)
    rows = []
    for flight in flights:
        shift = 0.05 * rng.standard_normal()
        for name, level in levels.items():
            for replica in range(n_trainings):
                value = level + shift + 0.001 * rng.standard_normal()
                row = {"training_set": name, "flight": flight, "replica": replica}
                rows.append(row | dict.fromkeys(METRICS, value))
    return pd.DataFrame(rows)


def test_the_table_holds_the_pairs_named_before_and_their_differences_flight_by_flight():
    sets = sorted({name for pair in ROLES for name in pair})
    levels = {name: 0.5 + 0.01 * number for number, name in enumerate(sets)}
    table = worth_table(scores_of(levels))
    ods = table[table["metric"] == "ods"].set_index(["training_set", "base"])
    assert tuple(ods.index[0]) == ("rd_pd", "rd_sample")
    assert ods.iloc[0]["role"] == "endpoint"
    pairs = ods[ods["role"].notna()]
    assert dict(pairs["role"]) == ROLES
    for name, base in pairs.index:
        row = pairs.loc[(name, base), ["flight_4000", "flight_4001", "flight_4002"]]
        # Of 2 trainings each with a scatter of .001: 4 standard deviations.
        assert_allclose(row.astype(float), levels[name] - levels[base], atol=0.004)
    assert len(ods) == len(ROLES) + len(sets)


def test_only_named_pairs_are_tested_and_secondary_ones_share_a_level():
    sets = {name for pair in ROLES for name in pair}
    table = worth_table(scores_of(dict.fromkeys(sets, 0.7)))
    tested = table[table["p"].notna()]
    assert set(tested["role"]) == {"endpoint", "secondary"}
    assert set(tested["metric"]) == {"ods"}
    adjusted = table[table["p_holm"].notna()]
    assert set(adjusted["role"]) == {"secondary"}
    assert (adjusted["p_holm"] >= adjusted["p"]).all()


def test_pairs_are_compared_where_both_sets_were_flown_and_secondary_ones_when_all_were():
    table = worth_table(scores_of({"rd": 0.7, "rd_sample": 0.7, "rd_pd": 0.7}))
    pairs = table[table["base"].notna()]
    compared = set(zip(pairs["training_set"], pairs["base"], strict=True))
    assert compared == {("rd_pd", "rd_sample"), ("rd_pd", "rd"), ("rd_sample", "rd")}
    assert list(table.loc[table["p"].notna(), "role"]) == ["endpoint"]
    assert table["p_holm"].isna().all()


def test_holm_s_method_is_that_of_the_published_example():
    # Holm (1979): the smallest of four is compared with a quarter of the level, the next a third.
    assert_allclose(holm(np.array([0.01, 0.04, 0.03, 0.005])), [0.03, 0.06, 0.06, 0.02])


def test_shares_by_depth_count_layers_once_a_flight():
    rows = []
    for flight in (1, 2):
        for replica, found in ((0, 10), (1, 30)):
            row = {"training_set": "rd", "flight": flight, "replica": replica}
            row |= {"depth_from_bins": 300, "n_true": 100, "n_found": found, "n_layers": 7}
            rows.append(row)
    (row,) = found_by_depth(pd.DataFrame(rows)).to_dict("records")
    assert row == {"training_set": "rd", "depth_from_bins": 300, "share": 0.2, "n_layers": 14}


def test_deep_layers_are_those_from_300_bins_on_and_count_by_their_pixels():
    columns = ["training_set", "flight", "depth_from_bins", "n_true", "n_found"]
    rows = [
        ("rd", 1, 250, 100, 100),
        ("rd", 1, 300, 100, 10),
        ("rd", 1, 550, 300, 50),
        ("rd", 2, 300, 100, 40),
    ]
    shares = share_of_deep(pd.DataFrame(rows, columns=columns))
    assert shares.loc["rd"].to_dict() == {1: 0.15, 2: 0.4}


def test_the_interval_over_flights_is_student_s_t():
    values = pd.Series([0.01, 0.03, 0.02, 0.00])
    found = mean_over_flights(values)
    expected = ttest_1samp(values, 0).confidence_interval(0.95)
    assert_allclose([found["low"], found["high"]], [expected.low, expected.high], rtol=1e-12)
    assert np.isnan(mean_over_flights(values[:1])["low"])
