import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy.ndimage import gaussian_filter, label
from skimage.morphology import thin as thin_of_skimage

from snowsim.metrics.edges import thin


@pytest.mark.parametrize("smooth", [0, 1, 2, 5])
@pytest.mark.parametrize("share", [0.3, 0.5, 0.7, 0.95, 1])
def test_thinning_equals_scikit_image_on_blobs_of_any_width_and_keeps_their_parts(
    rng, smooth, share
):
    noise = gaussian_filter(rng.standard_normal((90, 120)), smooth)
    mask = noise <= np.quantile(noise, share)
    thinned = thin(mask)
    assert_array_equal(thinned, thin_of_skimage(mask))
    assert not (thinned & ~mask).any()
    assert label(thinned, np.ones((3, 3)))[1] == label(mask, np.ones((3, 3)))[1]
    assert_array_equal(thin(thinned), thinned)
