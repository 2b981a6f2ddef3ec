"""What keeps a render from being the observed image: parts of its error, and the best that speckle allows."""

import numpy as np
from scipy.ndimage import gaussian_filter1d

from snowsim.echogram import DB_BELOW_NOISE_FLOOR

SMOOTH_LINES = 6.0  # [range lines] sigma of the mean along track; layers move by less than a bin over as many
PARTS = ("grey level", "mean by depth", "along track", "speckle of the render", "speckle observed", "speckle in common")


def without_speckle(image):
    """Image averaged along track by a Gaussian of `SMOOTH_LINES`, float."""
    return gaussian_filter1d(np.asarray(image, dtype=float), SMOOTH_LINES, axis=1, mode="nearest")


def error_parts(image, reference):
    """Mean square error of an 8-bit image, taken apart: a dict by `PARTS` [grey levels squared] that sums to it.

    `grey level`: of the means of the whole images; `mean by depth`: of row means, that removed; `along track`: of
    averages along track, both removed. Then what averaging takes away: of the render, of the observed image, and, with
    its sign, what they have in common with each other and with the averages. Images of different sizes are refused.
    """
    image, reference = np.asarray(image, dtype=float), np.asarray(reference, dtype=float)
    if image.shape != reference.shape:
        msg = f"image and reference must have one size, got {image.shape} and {reference.shape}"
        raise ValueError(msg)
    smooth_image, smooth_reference = without_speckle(image), without_speckle(reference)
    smooth = smooth_image - smooth_reference
    by_row = smooth.mean(axis=1, keepdims=True)
    parts = [
        smooth.mean() ** 2,
        np.mean((by_row - smooth.mean()) ** 2),
        np.mean((smooth - by_row) ** 2),
        np.mean((image - smooth_image) ** 2),
        np.mean((reference - smooth_reference) ** 2),
    ]
    in_common = np.mean((image - reference) ** 2) - sum(parts)
    return dict(zip(PARTS, map(float, [*parts, in_common]), strict=True))


def with_other_speckle(image, noise_floor_db, maximum_db, n_looks, *, rng):
    """The observed 8-bit image as it might have come out of the same snow: its mean power under new speckle.

    What similarity it has to the image is the best that any renderer reaches whose speckle is as strong and
    independent. `noise_floor_db` and `maximum_db` are what `snowsim.echogram.to_uint8` returns. Pixels are independent,
    Gamma(n_looks). Mean power is the image's average along track, where a few per cent of speckle stay: the bound is
    that much too good.
    """
    bottom_db = noise_floor_db - DB_BELOW_NOISE_FLOOR
    grey_per_db = 255 / (maximum_db - bottom_db)
    power = 10 ** ((np.asarray(image, dtype=float) / grey_per_db + bottom_db) / 10)
    mean_power = without_speckle(power)
    redrawn = mean_power * rng.gamma(n_looks, 1 / n_looks, mean_power.shape)
    return as_bytes((10 * np.log10(redrawn) - bottom_db) * grey_per_db)


def as_bytes(grey):
    """Grey levels rounded to 8 bits; those beyond the ends become the ends."""
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)
