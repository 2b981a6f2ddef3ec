import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from numpy.testing import assert_array_equal
from scipy.ndimage import gaussian_filter, label
from skimage.morphology import thin as thin_of_skimage

from snowsim.metrics.edges import thin


@settings(max_examples=200, deadline=None, derandomize=True)
@given(arrays(bool, array_shapes(min_dims=2, max_dims=2, max_side=12), elements=st.booleans()))
def test_thinning_equals_scikit_image_on_any_small_map(mask):
    assert_array_equal(thin(mask), thin_of_skimage(mask))


@pytest.mark.parametrize("smooth", [0, 1, 2, 5])
def test_thinning_equals_scikit_image_on_blobs_of_any_width(rng, smooth):
    for share in (0.3, 0.5, 0.7, 0.95):
        noise = gaussian_filter(rng.standard_normal((90, 120)), smooth)
        mask = noise < np.quantile(noise, share)
        assert_array_equal(thin(mask), thin_of_skimage(mask))


def test_full_map_thins_as_in_scikit_image():
    mask = np.ones((128, 256), dtype=bool)
    assert_array_equal(thin(mask), thin_of_skimage(mask))


def test_thinning_keeps_parts_and_is_idempotent(rng):
    mask = gaussian_filter(rng.standard_normal((80, 80)), 2) > 0
    thinned = thin(mask)
    assert not (thinned & ~mask).any()
    assert label(thinned, np.ones((3, 3)))[1] == label(mask, np.ones((3, 3)))[1]
    assert_array_equal(thin(thinned), thinned)


def test_stopping_early_keeps_more_and_goes_on_to_the_same_end(rng):
    differ = 0
    for _ in range(50):
        mask = gaussian_filter(rng.standard_normal((40, 40)), 1) > 0
        early = thin(mask, early=True)
        assert not (thin(mask) & ~early).any()
        differ += int((early != thin(mask)).any())
    assert differ > 0
