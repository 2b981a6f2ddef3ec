import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy.ndimage import gaussian_filter
from skimage.morphology import thin as thin_of_skimage
from slow_thinning import thin_slowly

from snowsim.metrics.edges import match_counts


@pytest.mark.parametrize("smooth", [0, 1, 2, 5])
@pytest.mark.parametrize("share", [0.3, 0.5, 0.7, 0.95, 1])
def test_maps_are_thinned_pixel_for_pixel_as_published_until_a_half_step_is_idle(
    rng, smooth, share
):
    noise = gaussian_filter(rng.standard_normal((90, 120)), smooth)
    mask = noise <= np.quantile(noise, share)
    assert_array_equal(thin_slowly(mask, early=False), thin_of_skimage(mask))
    expected = thin_slowly(mask, early=True)
    # At a distance of 0 as many pairs as pixels are the same pixels.
    counts = match_counts(mask, expected, [0.5], max_dist=0)
    assert {int(n[0]) for n in counts.values()} == {expected.sum()}
