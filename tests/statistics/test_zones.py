import numpy as np
import pytest
from numpy.testing import assert_array_equal

from snowsim.statistics.zones import zone_statistics


@pytest.mark.parametrize("n_zones", [1, 4, 6])
def test_zones_hold_equally_many_blocks(n_zones):
    rng = np.random.default_rng(8)
    level = rng.uniform(20, 60, (48, 1))
    means = level * np.array([1, 0.9, 0.8]) * np.exp(0.02 * rng.standard_normal((48, 3)))
    thickness = means[..., None] + rng.standard_normal((48, 3, 256))
    thickness[5, 2, 10] = np.nan  # one gap: its mean counts, its spectrum does not
    found = zone_statistics(thickness, n_zones=n_zones)
    assert found["zone_edge_bins"].size == n_zones + 1
    assert_array_equal(found["n_samples"][:, 0], 48 // n_zones)
    assert found["n_psd_samples"].sum() == 48 * 3 - 1
