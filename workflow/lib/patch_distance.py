"""How far renders are from observed scenes as what trackers see: patches described by numbers, and their distance.

No number of these is better for a smooth image: texture and brightness of layers must be as varied
as observed.
"""

import numpy as np

from snowsim.metrics.texture import autocorrelation

PATCH = 32  # [pixels] height and width
CLIPPED_AT = 4.0  # observed standard deviations: the kernel's cube leaves no patch to decide alone
DEGREE = 3
ABOUT_BINS = 6  # above and below layers: as far as their tails show


def describe_patches(image, mask):
    """Numbers of the patches of an image, (patch, number): depth, levels, textures, and the echo about layers.

    Row; mean; spread of pixels, of row means and of column means; autocorrelation of neighbours
    across and down; mean over pixels of layers less the patch's mean, and the same `ABOUT_BINS`
    rows above and below them, zero without any.
    """
    padded = np.pad(mask, ((ABOUT_BINS, ABOUT_BINS), (0, 0)))
    shifted = [padded[first : first + len(mask)] for first in (ABOUT_BINS, 2 * ABOUT_BINS, 0)]
    rows = []
    for row in range(0, image.shape[0] - PATCH + 1, PATCH):
        for line in range(0, image.shape[1] - PATCH + 1, PATCH):
            where = slice(row, row + PATCH), slice(line, line + PATCH)
            patch = image[where].astype(float)
            deviation = patch - patch.mean()
            flat = deviation - deviation.mean(axis=1, keepdims=True)
            about = [deviation[on[where]].mean() if on[where].any() else 0.0 for on in shifted]
            correlations = [
                autocorrelation(part, [1], along=along)[0] if np.ptp(part) > 0 else 0.0
                for part, along in ((flat, "range_line"), (deviation, "range_bin"))
            ]
            spreads = flat.std(), deviation.mean(axis=1).std(), deviation.mean(axis=0).std()
            rows.append([row, patch.mean(), *spreads, *correlations, *about])
    return np.array(rows)


def kernel_distance(rendered, observed):
    """Squared distance of two sets of numbers, (patch, number) each, unbiased: 0 in the mean for sets of one law.

    Maximum mean discrepancy with the kernel ``(x.y / d + 1)^3`` of numbers in observed standard
    deviations: Binkowski, Sutherland, Arbel & Gretton (2018), ICLR. ValueError unless both hold two
    patches.
    """
    if min(len(rendered), len(observed)) < 2:
        msg = (
            f"a distance needs two patches of either kind, got {len(rendered)} and {len(observed)}"
        )
        raise ValueError(msg)
    mean, spread = observed.mean(axis=0), observed.std(axis=0) + 1e-12
    x, y = (
        np.clip((part - mean) / spread, -CLIPPED_AT, CLIPPED_AT) for part in (rendered, observed)
    )

    def kernel(a, b):
        return (a @ b.T / a.shape[1] + 1) ** DEGREE

    within = [
        (k.sum() - np.trace(k)) / (len(k) * (len(k) - 1)) for k in (kernel(x, x), kernel(y, y))
    ]
    return float(sum(within) - 2 * kernel(x, y).mean())


def scenes_distance(rendered, observed):
    """`kernel_distance` of the patches of scenes from those of observed ones."""
    sets = (
        np.concatenate([describe_patches(s.image, s.mask()) for s in of])
        for of in (rendered, observed)
    )
    return kernel_distance(*sets)
