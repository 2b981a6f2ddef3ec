"""Label sets as printed: section V-B of Yari et al. (2021)."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from planted_labels import N_LINES, planted
from refusals import refusal
from scipy.signal import periodogram

from snowsim.echogram import Kind
from snowsim.front import scenes
from snowsim.labels import draw_paper_scene, echoes_of_layers, prepare
from snowsim.statistics import varied

WAVENUMBER = np.fft.rfftfreq(N_LINES)


def as_printed():
    """Planted statistics with the plain spectra of the estimator `paper`, red, by zone."""
    psd = np.zeros((4, 20, WAVENUMBER.size))
    of_zone = np.array([0.7, 0.9, 1.1, 1.3])[:, None, None]
    psd[..., 1:] = 40 * of_zone / (1 + (WAVENUMBER[1:] / 0.01) ** 2)
    psd[..., -1] /= 2
    return planted().assign(thickness_psd=(("zone", "slab", "wavenumber"), psd))


@pytest.fixture(scope="module")
def drawn():
    rng = np.random.default_rng(20120429)
    statistics = as_printed()
    return [draw_paper_scene(statistics, N_LINES, name=f"{i}", rng=rng) for i in range(800)]


def test_numbers_of_layers_and_first_slabs_are_uniform_and_the_surface_is_flat(drawn):
    counts = np.bincount([len(scene.layer_bins) - 1 for scene in drawn], minlength=41)
    assert counts[:5].sum() == 0
    # 800 / 36 = 22 a count, scatter 4.7: allow four and a half of those among 36.
    assert np.abs(counts[5:] - 800 / 36).max() < 21
    first = np.array([scene.notes["first_thickness_bins"] for scene in drawn])
    # Uniform over 25 bins: mean 27.5 to 7.2 / sqrt(800) = 0.26; allow four.
    assert_allclose(first.mean(), 27.5, atol=1.03)
    for scene in drawn:
        assert_array_equal(scene.layer_bins[0], 50)
        assert np.diff(scene.layer_bins, axis=0).min() >= 1
        assert_array_equal(scene.complete_layer_bins, scene.layer_bins)


def test_slabs_have_the_spectrum_of_their_zone_and_undulate_apart(drawn):
    psd = as_printed()["thickness_psd"].values
    density = np.zeros((2, N_LINES // 2))
    products = []
    for scene in drawn:
        thickness = np.diff(scene.layer_bins, axis=0)
        _, found = periodogram(thickness[:20])
        density += [each.sum(axis=0)[1:] for each in (found, psd[scene.zone, : len(found)])]
        about = thickness - thickness.mean(axis=1, keepdims=True)
        products.append((about[1:] * about[:-1]).mean() / (about**2).mean())
    # 800 scenes of a dozen slabs: each wavenumber to 1 %; allow five.
    assert_allclose(density[0] / density[1], 1, atol=0.06)
    assert abs(np.mean(products)) < 0.02


def test_power_is_one_for_a_layer_and_variances_lie_between_the_printed_bounds(drawn):
    variance = np.concatenate([scene.echoes.variance_bins2 for scene in drawn])
    assert 10 <= variance.min() < variance.max() <= 15
    # Of U(10, 15), some 18,000: mean to 1.44 / sqrt(n); allow four.
    assert_allclose(variance.mean(), 12.5, atol=4 * 1.44 / np.sqrt(variance.size))
    echoes = drawn[0].echoes
    assert_array_equal(echoes.power, echoes.power[:, :1] * np.ones(N_LINES))
    assert_array_equal(echoes.bins, drawn[0].layer_bins)
    assert (echoes.kind == Kind.LAYER).all()
    assert echoes.n_looks == 100


def test_wider_scenes_do_not_repeat_themselves(rng):
    scene = draw_paper_scene(as_printed(), 2 * N_LINES, name="", rng=rng)
    thickness = np.diff(scene.layer_bins, axis=0)
    assert np.abs(thickness[:, :N_LINES] - thickness[:, N_LINES:]).max() > 0.1


def test_statistics_without_a_plain_spectrum_are_refused(rng):
    with refusal("need thickness_psd, all finite"):
        draw_paper_scene(planted(), N_LINES, name="", rng=rng)


@pytest.mark.parametrize(
    "door",
    [
        lambda statistics: prepare(statistics, 64),
        lambda statistics: draw_paper_scene(statistics, 64, name="", rng=1),
        lambda statistics: echoes_of_layers(np.zeros((1, 4)), statistics),
        lambda statistics: scenes(2, statistics=statistics, rng=1),
        lambda statistics: varied(statistics, rng=1),
    ],
)
def test_statistics_of_an_earlier_version_are_refused_in_one_line(door):
    with refusal("statistics: content must be .* 4', got 'earlier': fit them"):
        door(planted().assign_attrs(content="earlier"))
