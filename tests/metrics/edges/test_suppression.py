import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal
from scipy.ndimage import gaussian_filter, map_coordinates
from slow_thinning import thin_slowly

from snowsim.metrics.edges import suppress
from snowsim.metrics.edges.suppression import tangent_across, triangle_filter


def suppress_slowly(prediction):
    """The same from SciPy's bilinear interpolation of the whole map."""
    smoothed = triangle_filter(prediction, 1)
    angle = np.arctan(tangent_across(smoothed))
    rows, lines = np.indices(prediction.shape)
    last_row, last_line = np.array(prediction.shape) - 1
    keep = np.ones(prediction.shape, dtype=bool)
    for side in (-1, 1):
        row = np.clip(rows + side * np.sin(angle), 0, last_row - 1e-3)
        line = np.clip(lines + side * np.cos(angle), 0, last_line - 1e-3)
        keep &= smoothed * 1.01 >= map_coordinates(smoothed, [row, line], order=1)
    ramp = np.clip(np.minimum(rows, last_row - rows) / 5, 0, 1)
    ramp *= np.clip(np.minimum(lines, last_line - lines) / 5, 0, 1)
    return np.where(keep, smoothed, 0) * ramp


def test_suppression_equals_an_independent_slow_one(rng):
    prediction = np.clip(gaussian_filter(rng.random((60, 70)), 1.5), 0, 1)
    # Differences are roundings of bilinear weights; where they could decide, 1.01 keeps the two
    # apart.
    assert_allclose(suppress(prediction), suppress_slowly(prediction), atol=1e-15)


def test_ridge_exactly_along_range_lines_keeps_its_width_as_published():
    # sign(0) = 0 in the published orientation: thinning has to do the rest.
    crest = np.exp(-0.5 * ((np.arange(100) - 50) / 2) ** 2)
    edges = suppress(np.tile(crest[:, None], 120))[:, 20:-20]
    assert ((edges > 0.5).sum(axis=0) == 5).all()
    assert_array_equal(np.nonzero(thin_slowly(edges > 0.5, early=True)[:, 5:-5])[0], 50)


@pytest.mark.parametrize("shape", [(1, 1), (1, 200), (3, 2), (200, 1), (6, 6), (30, 30)])
def test_maps_of_any_size_stay_in_range_and_serve_as_input_again(rng, shape):
    for prediction in (rng.random(shape), np.ones(shape)):
        edges = suppress(prediction)
        assert edges.shape == shape
        assert ((edges >= 0) & (edges <= 1)).all()
        suppress(edges)


def test_bad_predictions_are_refused_by_the_name_of_their_image():
    with refusal("^scene_7: prediction must .* got nan"):
        suppress(np.full((8, 8), np.nan), where="scene_7")


@pytest.mark.parametrize("name", ["emptypred_128x256", "m128x256_n6", "perfect_128x256"])
def test_suppression_equals_the_published_vectors(shared_data, name):
    with np.load(shared_data / "edge_scores" / "nms" / f"{name}.npz") as vectors:
        smoothed = triangle_filter(vectors["pred"].astype(float), 1)
        assert_array_equal(smoothed, vectors["smoothed"])
        angle = np.mod(np.arctan(tangent_across(smoothed)), np.pi)
        assert_allclose(angle, vectors["orient"], rtol=0, atol=1e-12)
        # Values of 1e-46, where the smoothing kernel ends, may fall on either side: 1e-16 is far
        # above them.
        assert_allclose(suppress(vectors["pred"]), vectors["nms_r1_s5_m101"], rtol=0, atol=1e-16)
