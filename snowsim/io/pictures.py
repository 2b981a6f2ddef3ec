"""Picks drawn on their echogram, for a quick look."""

import io

import numpy as np
from PIL import Image

from snowsim.io.files import written_whole

# Of picks by quality: good, moderate, bad.
COLOURS = np.array([[0, 158, 115], [240, 160, 0], [213, 0, 0]], dtype=np.uint8)


def write_picture(path, image, rows, quality):
    """Write an 8-bit image (range_bin, range_line) with layers drawn on it, whole or not at all.

    `rows` and `quality` (layer, range_line) are those of the picks, NaN where none is.
    """
    picture = np.repeat(image[:, :, None], 3, axis=2)
    nearest = np.rint(rows)
    inside = np.isfinite(rows) & (nearest >= 0) & (nearest <= len(image) - 1)
    _, line = np.nonzero(inside)
    picture[nearest[inside].astype(int), line] = COLOURS[quality[inside] - 1]
    buffer = io.BytesIO()
    Image.fromarray(picture).save(buffer, format="PNG", compress_level=6)
    with written_whole(path) as aside:
        aside.write_bytes(buffer.getvalue())
