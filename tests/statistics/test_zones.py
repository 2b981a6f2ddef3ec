from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.stats import norm

from snowsim import labels, statistics
from snowsim.statistics.blocks import periodogram
from snowsim.statistics.zones import zone_models, zone_statistics


@pytest.fixture(scope="module")
def divided(flight):
    rng = np.random.default_rng(8)
    level = rng.uniform(20, 60, (48, 1))
    means = level * np.array([1, 0.9, 0.8]) * np.exp(0.02 * rng.standard_normal((48, 3)))
    means[:, 0] = level[:, 0]
    thickness = means[..., None] + rng.standard_normal((48, 3, 256))
    thickness[5, 2, 10] = np.nan  # one gap: its mean counts, its spectrum does not
    depth = np.concatenate([np.zeros((48, 1, 256)), np.cumsum(thickness, axis=1)], axis=1)
    frame = statistics.summarise(*flight[0])[0]
    summary = [replace(frame, start_ns=i, depth_bins=part) for i, part in enumerate(depth)]
    return thickness, summary, zone_models(summary, 4, (1, 4, 6))


def test_four_zones_are_those_of_the_flight(divided):
    thickness, _, models = divided
    direct = zone_statistics(thickness)
    names = ("zone_edge_bins", "thickness_psd", "relative_thickness_mean")
    for name in (*names, "thickness_correlation", "n_samples"):
        # Sums of depths and their differences: to rounding.
        assert_allclose(models[1][name], direct[name], rtol=1e-9, err_msg=name)


def test_zones_hold_equally_many_blocks(divided):
    _, _, models = divided
    for model in models:
        n_zones = model.sizes["zone"]
        assert model.sizes["edge"] == n_zones + 1
        assert_array_equal(model["n_samples"][:, 0], 48 // n_zones)
        assert model["n_psd_samples"].sum() == 48 * 3 - 1


def test_likelihood_and_penalties_are_those_of_the_blocks(divided):
    thickness, _, models = divided
    whole = np.isfinite(thickness)
    mean = np.where(whole, thickness, 0).sum(axis=2) / whole.sum(axis=2)
    share = mean / mean[:, :1]
    total = 0
    for values in (share[:, 1], share[:, 2]):
        total += norm.logpdf(values, values.mean(), values.std(ddof=1)).sum()
    assert_allclose(models[0].attrs["means_log_likelihood"], total, rtol=1e-6)
    assert models[0].attrs["means_n_parameters"] == 4
    assert models[2].attrs["means_n_parameters"] == 24
    # Hurvich & Tsai (1989): 2 k n / (n - k - 1), of 8 blocks each 6.4.
    assert_allclose(models[2].attrs["means_aic_penalty"], 12 * 6.4)
    assert_allclose(models[2].attrs["means_bic_penalty"], 24 * np.log(8))


def test_white_undulations_have_no_dispersion_beyond_their_own(divided):
    thickness, _, models = divided
    # 144 periodograms of 127 wavenumbers, half of them independent: their relative variance to 3 %.
    assert 1 <= models[0].attrs["dispersion"] < 1.05
    held = np.isfinite(thickness[:, 2]).all(axis=1)
    density = periodogram(thickness[held, 2], tapered=True).mean(axis=0)
    assert_allclose(models[0]["block_psd"][0, 2], density, atol=1e-9)


def test_labels_are_drawn_from_any_number_of_zones(divided, rng):
    for model in divided[2]:
        prepared = labels.prepare(model, 64, surface="flat", radiometry="constant")
        assert np.isfinite(labels.draw(prepared, 64, rng=rng)).all()


def test_a_slab_in_too_few_blocks_adds_nothing(divided):
    _, summary, models = divided
    shallow = [replace(frame, depth_bins=frame.depth_bins[:3]) for frame in summary]
    (without,) = zone_models(shallow, 3, (1,))
    few = list(summary)
    for i, frame in enumerate(summary[3:], start=3):
        depth = frame.depth_bins.copy()
        depth[3] = np.nan
        few[i] = replace(frame, depth_bins=depth)
    (fewer,) = zone_models(few, 4, (1,))
    assert fewer["source"].values[0].tolist() == [0, 0, 2]
    assert fewer["n_samples"].values[0].tolist() == [48, 48, 3]
    for name in ("means_log_likelihood", "means_aic_penalty", "means_n_parameters"):
        assert_allclose(fewer.attrs[name], without.attrs[name], rtol=1e-9)
