"""Counts of made-up images at three thresholds."""

import numpy as np


def image_counts(share, n_images, *, rng):
    """Counts of images of 200 pixels each, of which about a share is matched."""
    n = np.full(3, 200)
    matched = rng.binomial(n, share, (n_images, 3))
    return [
        {"matched_truth": m, "n_truth": n, "matched_prediction": m, "n_prediction": n}
        for m in matched
    ]
