import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy.ndimage import gaussian_filter
from skimage.morphology import thin as thin_of_skimage

from snowsim.metrics.edges import thin


@pytest.mark.parametrize("smooth", [0, 1, 2, 5])
@pytest.mark.parametrize("share", [0.3, 0.5, 0.7, 0.95, 1])
def test_thinning_equals_scikit_image_on_blobs_of_any_width(rng, smooth, share):
    noise = gaussian_filter(rng.standard_normal((90, 120)), smooth)
    mask = noise <= np.quantile(noise, share)
    assert_array_equal(thin(mask), thin_of_skimage(mask))
