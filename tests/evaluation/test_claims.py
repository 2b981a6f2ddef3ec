"""Outcomes follow from tables by the stated rules."""

from functools import partial
from itertools import product

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose
from result_tables import SETS
from result_tables import table3_intervals as intervals
from scipy import stats

from evaluation.lib import claim_rules, claims
from evaluation.lib.claim_rules import (
    CONFIRMED,
    CONTRADICTED,
    MISSING,
    OPEN,
    mean_interval,
    side_of_zero,
    signed,
)
from evaluation.lib.claims import CLAIMS, check_claims, chi_square, doppler, expensive


def similarity_table(cgan_less_phy):
    phy = np.random.default_rng(3).normal(20, 1, 40)
    scenes = [f"test_{i}" for i in range(40)]
    table = pd.DataFrame(product(("phy", "cgan"), scenes), columns=["method", "scene"])
    psnr = [*phy, *(phy + cgan_less_phy)]
    rmse = [*phy, *(phy - cgan_less_phy)]
    return table.assign(psnr=psnr, rmse=rmse)


def test_the_mean_s_interval_is_student_s_and_one_value_has_none(rng):
    values = rng.normal(1, 2, 20)
    mean = values.mean()
    low, high = stats.t.interval(0.95, 19, loc=mean, scale=stats.sem(values))
    assert_allclose(mean_interval([*values, np.nan]), (mean, low, high), rtol=1e-12)
    _, low_of_one, _ = mean_interval([2.0])
    assert np.isnan(low_of_one)
    outcome, _ = claim_rules.paired_outcome([2.0])
    assert outcome == OPEN


def test_nineteen_of_twenty_intervals_hold_the_mean(rng):
    held = []
    for _ in range(2000):
        _, low, high = mean_interval(rng.normal(1, 2, 15))
        held.append(low <= 1 <= high)
    # Binomial, 2000 draws of 0.95: standard deviation 0.0049; four of them.
    assert_allclose(np.mean(held), 0.95, atol=4 * 0.0049)


def test_signs_of_an_interval_decide():
    assert side_of_zero(0.1, 0.2) == CONFIRMED
    assert side_of_zero(-0.2, -0.1) == CONTRADICTED
    assert side_of_zero(-0.1, 0.2) == side_of_zero(0.0, 0.2) == OPEN
    all_of = claim_rules.all_of
    assert all_of([CONFIRMED, CONFIRMED, CONFIRMED]) == CONFIRMED
    assert all_of([CONFIRMED, OPEN]) == OPEN
    assert all_of([CONFIRMED, CONTRADICTED]) == CONTRADICTED


@pytest.mark.parametrize(("shift", "outcome"), [(2.0, CONFIRMED), (-2.0, CONTRADICTED)])
@pytest.mark.parametrize(("metric", "sign"), [("psnr", 1), ("rmse", -1)])
def test_better_means_more_psnr_and_less_rmse(shift, outcome, metric, sign):
    noise = np.random.default_rng(1).normal(0, 1, 40)
    found = claims.better_similarity(similarity_table(shift + noise), metric, sign, "")
    assert found.outcome == outcome


def test_no_difference_and_what_could_not_be_measured_are_not_resolved():
    even = similarity_table(np.tile([1.0, -1.0], 20))
    found = claims.better_similarity(even, "psnr", 1, "")
    assert found.outcome == OPEN
    # A renderer whose images are constant above the surface has no texture there.
    values = {"observed": 0.03, "phy": 0.0, "cgan": np.nan}
    rows = [(f"s{i}", method, i * value) for i in range(4) for method, value in values.items()]
    table = pd.DataFrame(rows, columns=["scene", "method", "autocorrelation_line"])
    found = claims.needless_texture(table.assign(region="above", deviation=1.0))
    assert found.outcome == OPEN


def test_infinite_psnr_of_an_identical_image_is_left_out():
    table = similarity_table(2.0 + np.tile([0.1, -0.1], 20))
    identical = (table["scene"] == "test_0") & (table["method"] == "cgan")
    table.loc[identical, "psnr"] = np.inf
    found = claims.better_similarity(table, "psnr", 1, "dB")
    assert found.outcome == CONFIRMED
    assert "39 scenes" in found.numbers


def positions(cgan, phy):
    most_curved = ("curvature", 3)
    rows = []
    for scene, shape in product(range(5), (("slope", 3), ("curvature", 0), most_curved)):
        # Only the most curved quarter counts: elsewhere the sign is the other way round.
        elsewhere = 0 if shape == most_curved else 10
        # Differences that are equal in every scene have no spread; a little is real.
        of_phy = phy + elsewhere + 0.02 * (scene == 0)
        rows.append((f"s{scene}", "cgan", *shape, cgan))
        rows.append((f"s{scene}", "phy", *shape, of_phy))
        rows.append((f"s{scene}", "observed", *shape, 3.0))
    columns = ["scene", "method", "against", "shape_class", "mean_abs_error_bins"]
    return pd.DataFrame(rows, columns=columns)


def test_curvature_is_compared_where_layers_bend_most():
    phy_better = positions(cgan=2.0, phy=1.0)
    assert claims.curvature(phy_better).outcome == CONFIRMED
    cgan_better = positions(cgan=1.0, phy=2.0)
    assert claims.curvature(cgan_better).outcome == CONTRADICTED


def test_augmentation_needs_all_sets_to_gain_and_the_best_set_all_intervals_below_its_own():
    def augmented(rd_pd):
        fused = intervals(gains | {("fuse", "rd_pd"): rd_pd})
        return claims.augmentation(fused, "ods").outcome

    def best(**differences):
        planted = {("fuse", name): value for name, value in differences.items()}
        return claims.best_fuse(intervals(planted)).outcome

    gains = {("fuse", name): 0.02 for name in SETS[1:]}
    assert augmented(rd_pd=0.02) == CONFIRMED
    assert augmented(rd_pd=0.002) == OPEN
    assert augmented(rd_pd=-0.02) == CONTRADICTED
    assert best(rd_pd=0.03) == CONFIRMED
    assert best(rd_pd=0.03, rd_gd=0.025) == OPEN
    assert best(rd_gd=0.03) == CONTRADICTED
    assert best(rd_pd=-0.03) == CONTRADICTED


def test_side_outputs_are_counted_and_the_fifth_gets_worse_only_if_it_loses():
    leads = {(f"side_{side}", "rd_gd"): 0.02 for side in (1, 2, 3, 4)}
    assert claims.best_sides(intervals(leads)).outcome == CONFIRMED
    # Ahead, by less than an interval.
    narrowly = {(f"side_{side}", "rd_gd"): 0.002 for side in range(1, 6)}
    assert claims.best_sides(intervals(narrowly)).outcome == OPEN
    others = {(f"side_{side}", "rd_pd"): 0.03 for side in (1, 2)}
    assert claims.best_sides(intervals(leads | others)).outcome == CONTRADICTED
    worse = {("side_5", name): -0.1 for name in SETS[1:]}
    assert claims.fifth_side(intervals(worse)).outcome == CONFIRMED
    better = dict.fromkeys(worse, 0.1)
    assert claims.fifth_side(intervals(better)).outcome == CONTRADICTED
    assert claims.fifth_side(intervals()).outcome == OPEN


def test_all_outputs_improve_only_if_a_set_gains_on_each():
    gains = {(f"side_{side}", "rd_gd"): 0.02 for side in range(1, 6)} | {("fuse", "rd_pd"): 0.02}
    assert claims.all_outputs(intervals(gains)).outcome == CONFIRMED
    even = gains | {("side_3", "rd_gd"): 0.0}
    assert claims.all_outputs(intervals(even)).outcome == OPEN
    losses = {("side_3", name): -0.02 for name in SETS[1:]}
    assert claims.all_outputs(intervals(gains | losses)).outcome == CONTRADICTED


@pytest.mark.parametrize(("n_rejected", "outcome"), [(5, CONFIRMED), (20, CONTRADICTED)])
def test_thickness_is_gaussian_unless_more_tests_reject_than_chance_allows(n_rejected, outcome):
    # Of 100 tests, chance rejects up to 10 in 97.5 % of flights.
    p_value = np.where(np.arange(100) < n_rejected, 0.01, 0.5)
    table = pd.DataFrame({"of": "undulation", "p_value_correlated": p_value})
    assert claims.gaussian(table).outcome == outcome


@pytest.mark.parametrize(("shift", "outcome"), [(0, CONFIRMED), (3, CONTRADICTED)])
def test_distributions_are_told_apart_by_their_largest_difference(rng, shift, outcome):
    low_bins = np.arange(10, 40)
    ends = np.append(low_bins, 40)
    observed = np.histogram(rng.normal(25, 3, 100), ends)[0]
    synthetic = np.histogram(rng.normal(25 + shift, 3, 1000), ends)[0]
    table = {"zone": 0, "slab": -1, "low_bins": low_bins}
    table |= {"n_observed": observed, "n_synthetic": synthetic}
    assert claims.same_distribution(pd.DataFrame(table)).outcome == outcome


@pytest.mark.parametrize(("factor", "outcome"), [(1.2, CONFIRMED), (1.3, CONTRADICTED)])
def test_spectra_agree_within_a_decibel_in_every_octave(factor, outcome):
    # 0.8 and 1.1 dB in one of seven octaves.
    wavenumber = np.arange(1, 129) / 256
    off = np.where((wavenumber >= 1 / 16) & (wavenumber < 1 / 8), factor, 1.0)
    table = {"wavenumber": wavenumber, "observed": 2.0, "synthetic": 2 * off}
    assert claims.same_spectra(pd.DataFrame(table)).outcome == outcome


@pytest.mark.parametrize(("spread", "outcome"), [(0.5, CONFIRMED), (1, OPEN), (2, CONTRADICTED)])
def test_observed_scenes_vary_more_where_those_rendered_spread_less(rng, spread, outcome):
    common = rng.standard_normal(200)
    values = {"observed": 20 + common + 0.5 * rng.standard_normal(200)}
    for method in ("cgan", "phy"):
        values[method] = 20 + spread * (common + 0.5 * rng.standard_normal(200))
    table = pd.DataFrame(values).rename_axis("scene").reset_index()
    table = table.melt("scene", var_name="method", value_name="deviation").assign(region="below")
    assert claims.observed_vary_more(table).outcome == outcome


@pytest.mark.parametrize(
    ("layering_db", "scene_db", "outcome"),
    [(0.1, 0.1, CONFIRMED), (0.6, 0.1, OPEN), (0.6, 0.6, CONTRADICTED)],
)
def test_the_convolution_captures_what_it_leaves_out_less_than_speckle(
    layering_db, scene_db, outcome
):
    rows = [
        ("stacks", "fine layering", 50, "convolution", layering_db),
        ("scene", "whole scene", 0, "PHY", scene_db),
    ]
    table = pd.DataFrame(rows, columns=["part", "sweep", "value", "method", "error_db"])
    assert claims.captures(table).outcome == outcome


@pytest.mark.parametrize(("factor", "outcome"), [(1.04, CONFIRMED), (1.06, CONTRADICTED)])
def test_tracked_power_agrees_within_five_percent_or_not(factor, outcome):
    probability = np.array([0.001, 0.1, 0.5, 0.9, 0.999])
    gamma = stats.gamma(5, scale=0.2).ppf(probability)
    tracked = gamma * np.array([9, 1, factor, 1, 9])  # beyond 1 % and 99 % nothing counts
    quantiles = {"probability": probability, "gamma": gamma, "tracked": tracked}
    table = pd.DataFrame(quantiles).assign(n_looks=5.0)
    assert chi_square(table).outcome == outcome


@pytest.mark.parametrize(
    ("value", "outcome"), [(0.7, CONFIRMED), (4.0, CONTRADICTED), (np.nan, OPEN)]
)
def test_a_spectrum_is_flat_below_three_decibels(value, outcome):
    quantities = ["line spacing", "Doppler spectrum, highest over lowest"]
    table = pd.DataFrame({"quantity": quantities, "value": [9.0, value]})
    assert doppler(table).outcome == outcome


@pytest.mark.parametrize(
    ("seconds", "error_db", "outcome"),
    [(1.0, 0.1, CONFIRMED), (1.0, 0.6, OPEN), (0.05, 0.1, OPEN), (0.05, 0.6, CONTRADICTED)],
)
def test_a_solver_is_too_expensive_only_if_it_costs_much_and_adds_little(
    seconds, error_db, outcome
):
    rows = [
        ("stacks", "fine layering", 100, "convolution", 1e-9, 9.0),
        ("stacks", "fine layering", 50, "convolution", 1e-9, error_db),
        ("scene", "whole scene", 0, "PHY", 1e-3, 0.05),
        ("scene", "whole scene", 1, "PHY", 2e-3, 0.05),
        ("scene", "extrapolated", 0, "transfer matrix, stack", seconds, 0.0),
    ]
    columns = ["part", "sweep", "value", "method", "seconds", "error_db"]
    found = expensive(pd.DataFrame(rows, columns=columns))
    assert found.outcome == outcome
    assert f"{seconds / 1e-3:,.0f} times" in found.numbers


def test_what_the_flight_was_built_to_have_is_no_confirmation():
    quantities = ["Doppler spectrum, highest over lowest"]
    doppler_table = pd.DataFrame({"quantity": quantities, "value": [0.7]})
    config = {"source": "reference", "phy": {"n_looks": 16}, "benchmark": {"n_looks": 16}}
    tables = {"realism": doppler_table, "config": config}

    def built(tables, **options):
        found = check_claims(tables, **options)
        return {claim.tables[0] for claim in found if claim.by_construction}

    assert built(tables) == {"realism", "config"}
    assert built(tables, synthetic=False) == set()
    # What came out otherwise all the same is counted with the rest.
    uneven = doppler_table.assign(value=9.0)
    more_looks = config | {"phy": {"n_looks": 100}}
    assert built({"realism": uneven, "config": more_looks}) == set()


@pytest.mark.parametrize(("n_replicas", "few"), [(2, True), (5, False)])
def test_differences_of_few_trainings_are_indicative(n_replicas, few):
    table = intervals().assign(n_replicas=n_replicas)
    augmentation = partial(claims.augmentation, metric="ods")
    rules = (augmentation, claims.best_fuse, claims.best_sides, claims.all_outputs)
    for rule in (*rules, claims.fifth_side):
        caveat = rule(table).caveat
        assert ("indicative" in caveat) == few


def test_a_claim_without_its_table_says_which_is_missing():
    found = check_claims({})
    assert len(found) == len(CLAIMS)
    assert {claim.outcome for claim in found} == {MISSING}
    for claim, (_, needed, _) in zip(found, CLAIMS, strict=True):
        assert needed in claim.numbers


def test_differences_are_written_with_their_sign():
    assert signed(-0.0105) == "\N{MINUS SIGN}0.011"
    assert signed(2.375) == "+2.38"
    assert signed(np.nan) == "unknown"
