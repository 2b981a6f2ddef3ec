"""Counts against those of py-bsds500 on 14 maps, which were scored without suppression."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from snowsim.metrics.edges import match_counts

NAMES = ["00_m128x256_n3", "02_m128x256_n10", "04_m128x256_n22", "06_m192x320_n8", "07_m192x320_n14", "09_m192x320_n30"]
NAMES += ["11_m321x481_n12", "15_steps4conn_192x320_n10", "17_noisy_128x256_n8", "20_sideways_128x512"]
NAMES += ["22_emptypred_128x256", "24_ones_128x256", "26_px_1x1_hit", "28_row_1x200"]


@pytest.mark.parametrize("name", NAMES)
def test_the_default_lies_within_the_reference_s_own_error_on_every_map(shared_data, name):
    with np.load(shared_data / "edge_scores" / f"{name}.npz") as file:
        reference = dict(file)
    given = (reference[key] for key in ("pred", "gt", "thresholds"))
    counts = match_counts(*given, max_dist=float(reference["max_dist"]), thin=True)
    assert_array_equal(counts["n_truth"], reference["sum_r"])
    # Both stop thinning at the same pixel; thinned until nothing changes, 7 of the 14 maps have up to 11 pixels less.
    assert_array_equal(counts["n_prediction"], reference["sum_p"])
    # Same pixels: a maximum matching cannot be smaller; the reference's random outliers cost it up to 0.6 %.
    surplus = counts["matched_truth"] - reference["count_r"]
    assert (surplus >= 0).all()
    assert (surplus <= max(3, 0.006 * reference["gt"].sum())).all()
