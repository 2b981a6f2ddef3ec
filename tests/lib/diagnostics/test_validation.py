"""Tests of normality are calibrated; tables hold what the flight holds; one line is the sum of its layers."""

import numpy as np
import pandas as pd
import pytest
from made_up import made_up_frame
from numpy.testing import assert_allclose
from scipy.stats import kstest

from lib.diagnostics.validation import (
    independence,
    lilliefors,
    superposition,
    thickness_tests,
    validate,
)
from snowsim import statistics


def test_published_critical_values_have_their_probabilities():
    # Stephens (1974), table 1A: modified distances exceeded in 15, 10, 5 and 1 % of Gaussian
    # samples.
    values = np.random.default_rng(0).standard_normal(100)
    distance, _ = lilliefors(values)
    for modified, probability in ((0.775, 0.15), (0.819, 0.10), (0.895, 0.05), (1.035, 0.01)):
        # The number of values at which this distance stands at the critical value.
        n = ((modified / distance + np.sqrt((modified / distance) ** 2 - 4 * 0.84)) / 2) ** 2
        assert abs(lilliefors(values, n)[1] - probability) < 0.1 * probability + 0.003


@pytest.mark.parametrize("n", [5, 20, 200])
def test_probabilities_of_gaussian_values_are_uniform(rng, n):
    p_values = [lilliefors(3 + 2 * rng.standard_normal(n))[1] for _ in range(400)]
    # 400 uniform values lie within 1.63 / 20 = 0.08 of the diagonal but for 1 % of the time.
    assert kstest(p_values, "uniform").statistic < 0.09


def test_other_laws_are_distinguished_from_a_gaussian(rng):
    assert lilliefors(rng.exponential(size=200))[1] < 0.001
    assert lilliefors(rng.uniform(size=500))[1] < 0.01
    with pytest.raises(ValueError, match="4 values that differ, got 3"):
        lilliefors([1.0, 2, 3])
    with pytest.raises(ValueError, match="from 2 to 2"):
        lilliefors(np.full(9, 2.0))


def red_thickness(rng, n_blocks=40, n_slabs=12, power=1.0):
    """Thickness with long undulations; `power` bends it away from a Gaussian."""
    wavenumber = np.fft.rfftfreq(256)
    shape = np.sqrt(1 / (1 + (wavenumber / 0.01) ** 2))
    normal = rng.standard_normal((2, n_blocks, n_slabs, 129))
    series = np.fft.irfft((normal[0] + 1j * normal[1]) * shape, 256)
    series /= series.std()
    bent = np.sign(series) * np.abs(series) ** power
    level = rng.uniform(30, 50, (n_blocks, 1, 1)) * (
        1 + 0.05 * rng.standard_normal((1, n_slabs, 1))
    )
    means = level * (1 + 0.02 * rng.standard_normal((n_blocks, n_slabs, 1)))
    return means + 2 * bent


def test_correlated_gaussian_thickness_passes_where_counting_every_line_does_not_and_another_law_fails(
    rng,
):
    rows = pd.DataFrame(thickness_tests(red_thickness(rng), [30.0, 40, 50], rng=rng))
    undulation = rows[rows["of"] == "undulation"]
    assert (undulation["p_value"] < 0.01).mean() > 0.3
    # 24 probabilities of multiples of 1 / 200: within 1.63 / sqrt(24) = 0.33 of the diagonal.
    assert kstest(undulation["p_value_correlated"], "uniform").statistic < 0.33
    assert (undulation["n_effective"] < 0.1 * undulation["n"]).all()
    means = rows[rows["of"] == "relative block mean"]
    assert set(means["slab"]) == set(range(1, 12))
    assert kstest(means["p_value_correlated"], "uniform").statistic < 0.34
    assert (means["n_effective"] <= means["n"]).all()
    rows = pd.DataFrame(thickness_tests(red_thickness(rng, power=4.0), [30.0, 40, 50], rng=rng))
    assert (rows.loc[rows["of"] == "undulation", "p_value_correlated"] < 0.05).mean() > 0.8


def test_level_slabs_and_zones_without_blocks_have_no_test(rng):
    thickness = np.full((8, 3, 256), 40.0)
    assert thickness_tests(thickness, [30.0, 50], rng=rng) == []
    gaps = red_thickness(rng, n_blocks=8)
    gaps[:, :, 5] = np.nan
    rows = thickness_tests(gaps, [0.0, 1, 100], rng=rng)
    assert {row["of"] for row in rows} == {"relative block mean"}
    assert {row["zone"] for row in rows} == {1}


@pytest.fixture(scope="module")
def summary(flight):
    return statistics.merge(statistics.summarise(*frame) for frame in flight)


def test_tables_count_every_line_and_block_once(summary, rng):
    fitted = statistics.estimate(summary)
    layers = pd.DataFrame({"n_layers": [5, 6], "n_scenes": [3, 7]})
    histograms = pd.DataFrame(
        {"zone": [0, 3], "slab": [0, -1], "low_bins": [500, 41], "n": [256, 1]}
    )
    tables = validate(
        summary, fitted, fitted, (layers, histograms), fitted["zone_edge_bins"], rng=rng
    )
    thickness = tables["thickness"]
    counts = thickness[thickness["slab"] >= 0].groupby("slab")["n_observed"].sum()
    assert counts.to_dict() == dict.fromkeys(range(4), 4 * 256)
    assert thickness.loc[thickness["slab"] == -1, "n_observed"].sum() == 4
    assert thickness.loc[thickness["low_bins"] == 500, "n_synthetic"].to_list() == [256]
    first = thickness[thickness["slab"] == 0]
    mean = (first["n_observed"] * (first["low_bins"] + 0.5)).sum() / first["n_observed"].sum()
    observed = np.mean([np.diff(frame.depth_bins, axis=0)[0].mean() for frame in summary])
    # Bins of one: thickness is even within them to a few hundredths.
    assert_allclose(mean, observed, atol=0.1)
    numbers = tables["distributions"].groupby("quantity")[["n_observed", "n_synthetic"]].sum()
    assert numbers.loc["n_layers"].to_list() == [4, 10]
    assert numbers.loc["width_bins", "n_observed"] == numbers.loc["width_bins", "n_synthetic"] > 0
    held = tables["distributions"].query("quantity == 'n_layers' and n_observed > 0")
    assert held[["low", "high"]].to_numpy().tolist() == [[3.5, 4.5]]
    assert set(tables["tests"]["of"]) <= {"relative block mean", "undulation"}


@pytest.mark.parametrize("estimator", statistics.ESTIMATORS)
def test_a_line_is_the_sum_of_its_layers(summary, estimator):
    fitted = statistics.estimate(summary, estimator=estimator)
    line = superposition(summary, fitted)
    alone = line.filter(like="layer_")
    assert alone.shape[1] == 5
    assert_allclose(alone.sum(axis=1) + float(fitted["noise_power"]), line["model"], rtol=1e-12)
    assert np.isfinite(line.to_numpy()).all()
    if estimator == "deblended":
        # 20 lines of 100 looks scatter by 2.2 %, and the surface moves within the group.
        ratio = (line["observed"] / line["model"])[line["row"].between(-5, 180)]
        assert abs(ratio.mean() - 1) < 0.01
        assert ratio.std() < 0.05


def test_layers_of_a_planted_line_have_their_powers(planted):
    summary = statistics.summarise(*made_up_frame(*planted.level()))
    line = superposition(summary, statistics.estimate(summary))
    # Without speckle what is left is where the fit ends, and rows on which no waveform's peak
    # falls.
    assert_allclose(line.filter(like="layer_").max(), planted.peak_power, rtol=0.01)


def test_a_planted_misfit_and_planted_looks_come_back_by_layer(flight):
    summary = statistics.merge(statistics.summarise(*frame) for frame in flight)
    fitted = statistics.fit(flight)
    found = independence(summary, fitted).set_index("layer")
    assert (
        np.abs(found["looks"] - fitted.attrs["n_looks"]) < 4 * found["looks_standard_error"]
    ).all()
    # 1.36 / sqrt(n) is exceeded once in 20 by n independent values; the mean taken out of 20 lines
    # leaves less.
    assert (found["gamma_distance"] < 2 / np.sqrt(19 * found["n_groups"])).all()
    bent = fitted.assign(mean_waveform=fitted["model_waveform"] * 10**0.2)
    assert_allclose(independence(summary, bent)["waveform_rms_db"], 2, rtol=1e-9)
