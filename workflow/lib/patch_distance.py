"""How far renders are from observed scenes as what trackers see: distance of described patches.

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
    """Numbers of the patches of an image, (patch, number): depth, levels, textures, echoes.

    Row; mean; spread of pixels, of row means and of column means; autocorrelation of neighbours
    across and down; mean over pixels of layers less the patch's mean, and the same `ABOUT_BINS`
    rows above and below them, zero without any.
    """
    padded = np.pad(mask, ((ABOUT_BINS, ABOUT_BINS), (0, 0)))
    height, width = mask.shape
    on_above_below = [padded[first : first + height] for first in (ABOUT_BINS, 2 * ABOUT_BINS, 0)]
    patches = []
    for row in range(0, height - PATCH + 1, PATCH):
        for line in range(0, width - PATCH + 1, PATCH):
            window = (slice(row, row + PATCH), slice(line, line + PATCH))
            patch = image[window].astype(float)
            numbers = [row, patch.mean(), *_texture(patch - patch.mean())]
            patches.append(numbers + _echo(patch, [where[window] for where in on_above_below]))
    return np.array(patches)


def _texture(deviation):
    """Spreads and autocorrelations of a patch less its mean."""
    of_rows = deviation.mean(axis=1)
    flat = deviation - of_rows[:, None]
    spreads = [flat.std(), of_rows.std(), deviation.mean(axis=0).std()]
    return [*spreads, _neighbours(flat, "range_line"), _neighbours(deviation, "range_bin")]


def _neighbours(part, along):
    if np.ptp(part) == 0:
        return 0.0
    return autocorrelation(part, [1], along=along)[0]


def _echo(patch, places):
    """Mean level at each of some places, bool like the patch, less the patch's; 0 for none."""
    deviation = patch - patch.mean()
    return [deviation[where].mean() if where.any() else 0.0 for where in places]


def kernel_distance(rendered, observed):
    """Squared distance of two sets of numbers, (patch, number) each, unbiased: 0 for one law.

    Maximum mean discrepancy with the kernel ``(x.y / d + 1)^3`` of numbers in observed standard
    deviations: Binkowski, Sutherland, Arbel & Gretton (2018), ICLR. ValueError unless both hold two
    patches.
    """
    if min(len(rendered), len(observed)) < 2:
        msg = "a distance needs two patches of either kind, "
        msg += f"got {len(rendered)} and {len(observed)}"
        raise ValueError(msg)
    mean = observed.mean(axis=0)
    spread = observed.std(axis=0) + 1e-12

    def clipped(numbers):
        return np.clip((numbers - mean) / spread, -CLIPPED_AT, CLIPPED_AT)

    def kernel(a, b):
        return (a @ b.T / a.shape[1] + 1) ** DEGREE

    def within(numbers):
        likeness = kernel(numbers, numbers)
        n_pairs = len(likeness) * (len(likeness) - 1)
        return (likeness.sum() - np.trace(likeness)) / n_pairs

    x = clipped(rendered)
    y = clipped(observed)
    return float(within(x) + within(y) - 2 * kernel(x, y).mean())


def scenes_distance(rendered, observed):
    """`kernel_distance` of the patches of scenes from those of observed ones."""
    return kernel_distance(_described(rendered), _described(observed))


def _described(scenes):
    return np.concatenate([describe_patches(scene.image, scene.mask()) for scene in scenes])
