from itertools import combinations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from snowsim.metrics.picks import match_picks


def best_saving(true, found, reach):
    """Most that any order-keeping assignment saves, by enumeration."""
    best = 0.0
    for n in range(1, min(len(true), len(found)) + 1):
        for layers in combinations(range(len(true)), n):
            for picks in combinations(range(len(found)), n):
                distance = np.abs(true[list(layers)] - found[list(picks)])
                if (distance < reach).all():
                    best = max(best, (reach - distance).sum())
    return best


def test_assignment_is_the_best_of_all_that_keep_the_order(rng):
    for _ in range(60):
        true, found = (np.sort(rng.uniform(0, 40, rng.integers(1, 6))) for _ in range(2))
        error, used = match_picks(found[:, None], true[:, None], max_distance_bins=8)
        kept = np.isfinite(error)
        assert kept.sum() == used.sum()
        assert_allclose((8 - np.abs(error[kept])).sum(), best_saving(true, found, 8), atol=1e-9)


@pytest.mark.parametrize(
    ("picks", "message"),
    [
        ([[5.0, 5.0], [4.0, 6.0]], "picks: layers must increase strictly"),
        ([[5.0]], "picks cover 1 range lines, the layers 2"),
    ],
)
def test_picks_that_cannot_be_matched_are_refused(picks, message):
    with pytest.raises(ValueError, match=message):
        match_picks(picks, [[5.0, 5.0]])
