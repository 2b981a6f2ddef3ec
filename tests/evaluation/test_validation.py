"""Tests of normality are calibrated; tables hold what the flight holds; a line is its layers."""

import numpy as np
import pandas as pd
import pytest
from made_up import made_up_frame
from numpy.testing import assert_allclose
from scipy.stats import kstest

from evaluation.lib.validation import (
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
    for modified, probability in {0.775: 0.15, 0.819: 0.10, 0.895: 0.05, 1.035: 0.01}.items():
        # The number of values at which this distance stands at the critical value.
        ratio = modified / distance
        n = ((ratio + np.sqrt(ratio**2 - 4 * 0.84)) / 2) ** 2
        _, p_value = lilliefors(values, n)
        assert abs(p_value - probability) < 0.1 * probability + 0.003


@pytest.mark.parametrize("n", [5, 20, 200])
def test_probabilities_of_gaussian_values_are_uniform(rng, n):
    p_values = [lilliefors(3 + 2 * rng.standard_normal(n))[1] for _ in range(400)]
    # 400 uniform values lie within 1.63 / 20 = 0.08 of the diagonal but for 1 % of the time.
    assert kstest(p_values, "uniform").statistic < 0.09


def test_other_laws_are_distinguished_from_a_gaussian(rng):
    _, of_exponential = lilliefors(rng.exponential(size=200))
    assert of_exponential < 0.001
    _, of_uniform = lilliefors(rng.uniform(size=500))
    assert of_uniform < 0.01
    with pytest.raises(ValueError, match="4 values that differ, got 3"):
        lilliefors([1.0, 2, 3])
    with pytest.raises(ValueError, match="from 2 to 2"):
        lilliefors(np.full(9, 2.0))


def red_thickness(rng, n_blocks=40, n_slabs=12, power=1.0):
    """Thickness with long undulations; `power` bends it away from a Gaussian."""
    wavenumber = np.fft.rfftfreq(256)
    shape = np.sqrt(1 / (1 + (wavenumber / 0.01) ** 2))
    real, imaginary = rng.standard_normal((2, n_blocks, n_slabs, 129))
    series = np.fft.irfft((real + 1j * imaginary) * shape, 256)
    series /= series.std()
    bent = np.sign(series) * np.abs(series) ** power
    level = rng.uniform(30, 50, (n_blocks, 1, 1))
    of_slab = 1 + 0.05 * rng.standard_normal((1, n_slabs, 1))
    of_block = 1 + 0.02 * rng.standard_normal((n_blocks, n_slabs, 1))
    return level * of_slab * of_block + 2 * bent


def test_correlated_gaussian_thickness_passes_where_counting_lines_does_not_and_others_fail(rng):
    edges = [30.0, 40, 50]
    rows = pd.DataFrame(thickness_tests(red_thickness(rng), edges, rng=rng))
    undulation = rows[rows["of"] == "undulation"]
    assert (undulation["p_value"] < 0.01).mean() > 0.3
    # 24 probabilities of multiples of 1 / 200: within 1.63 / sqrt(24) = 0.33 of the diagonal.
    assert kstest(undulation["p_value_correlated"], "uniform").statistic < 0.33
    assert (undulation["n_effective"] < 0.1 * undulation["n"]).all()
    means = rows[rows["of"] == "relative block mean"]
    assert set(means["slab"]) == set(range(1, 12))
    assert kstest(means["p_value_correlated"], "uniform").statistic < 0.34
    assert (means["n_effective"] <= means["n"]).all()
    rows = pd.DataFrame(thickness_tests(red_thickness(rng, power=4.0), edges, rng=rng))
    p_values = rows.loc[rows["of"] == "undulation", "p_value_correlated"]
    assert (p_values < 0.05).mean() > 0.8


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
    of_labels = [(0, 0, 500, 256), (3, -1, 41, 1)]
    histograms = pd.DataFrame(of_labels, columns=["zone", "slab", "low_bins", "n"])
    labels = (layers, histograms)
    tables = validate(summary, fitted, fitted, labels, fitted["zone_edge_bins"], rng=rng)
    thickness = tables["thickness"]
    of_slabs = thickness[thickness["slab"] >= 0]
    counts = of_slabs.groupby("slab")["n_observed"].sum()
    assert counts.to_dict() == dict.fromkeys(range(4), 4 * 256)
    assert thickness.loc[thickness["slab"] == -1, "n_observed"].sum() == 4
    assert thickness.loc[thickness["low_bins"] == 500, "n_synthetic"].to_list() == [256]
    first = thickness[thickness["slab"] == 0]
    mean = np.average(first["low_bins"] + 0.5, weights=first["n_observed"])
    by_frame = [(frame.depth_bins[1] - frame.depth_bins[0]).mean() for frame in summary]
    observed = np.mean(by_frame)
    # Bins of one: thickness is even within them to a few hundredths.
    assert_allclose(mean, observed, atol=0.1)
    distributions = tables["distributions"]
    numbers = distributions.groupby("quantity")[["n_observed", "n_synthetic"]].sum()
    assert numbers.loc["n_layers"].to_list() == [4, 10]
    assert numbers.loc["width_bins", "n_observed"] == numbers.loc["width_bins", "n_synthetic"] > 0
    held = distributions.query("quantity == 'n_layers' and n_observed > 0")
    assert held[["low", "high"]].to_numpy().tolist() == [[3.5, 4.5]]
    assert set(tables["tests"]["of"]) <= {"relative block mean", "undulation"}


@pytest.mark.parametrize("estimator", statistics.ESTIMATORS)
def test_a_line_is_the_sum_of_its_layers(summary, estimator):
    fitted = statistics.estimate(summary, estimator=estimator)
    line = superposition(summary, fitted)
    alone = line.filter(like="layer_")
    assert alone.shape[1] == 5
    total = alone.sum(axis=1) + float(fitted["noise_power"])
    assert_allclose(total, line["model"], rtol=1e-12)
    assert np.isfinite(line.to_numpy()).all()
    if estimator == "deblended":
        # 20 lines of 100 looks scatter by 2.2 %, and the surface moves within the group.
        inner = line[line["row"].between(-5, 180)]
        ratio = inner["observed"] / inner["model"]
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
    off = np.abs(found["looks"] - fitted.attrs["n_looks"])
    assert (off < 4 * found["looks_standard_error"]).all()
    # 1.36 / sqrt(n) is exceeded once in 20 by n independent values; the mean taken out of 20 lines
    # leaves less.
    most = 2 / np.sqrt(19 * found["n_groups"])
    assert (found["gamma_distance"] < most).all()
    bent = fitted.assign(mean_waveform=fitted["model_waveform"] * 10**0.2)
    of_bent = independence(summary, bent)
    assert_allclose(of_bent["waveform_rms_db"], 2, rtol=1e-9)
