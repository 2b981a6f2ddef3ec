"""Grey PNG images, and the numbers that travel in their text chunks."""

import warnings
from contextlib import contextmanager

import numpy as np
from PIL import Image

from snowsim.io.guard import existing, library_errors, one_line, refusal

MAXIMUM_PIXELS = 2**26  # 256 columns of 262144 rows; below the size at which Pillow itself warns
NUMBERS_IN_TEXT = {"noise_floor_db": float, "maximum_db": float, "zone": int}


def read_image(path, *, binary=False):
    """Grey PNG image as uint8 (range_bin, range_line), and the numbers kept in its text chunks.

    Parameters
    ----------
    path : path_like
    binary : bool
        Expect a mask: 1-bit, or two grey levels of which one is 0; returned as bool.

    Returns
    -------
    image : ndarray
    texts : dict
        `noise_floor_db`, `maximum_db`, `zone` as far as the file has them.

    Raises
    ------
    ValueError
        If the file is no whole, grey PNG image of a bearable size.
    """
    path = existing(path)
    with _opened(path, binary) as file:
        values = np.array(file)
        texts = _numbers_in_text(path, dict(file.text))
    if not binary:
        return values, texts
    levels = np.unique(values)
    if levels.size > 2 or (levels.size == 2 and levels[0] != 0):
        found = f"{levels.size} levels from {levels[0]} to {levels[-1]}"
        raise refusal(path, "mask", "1 bit, or two grey levels of which one is 0", found)
    return values > 0, texts


def image_height(path):
    """Rows of a grey PNG image, without its pixels being read; ValueError as from `read_image`."""
    with _opened(existing(path), binary=False) as file:
        return file.size[1]


@contextmanager
def _opened(path, binary):
    """The image, opened, found to be grey and of a bearable size; pixels are read in the `with` block."""
    with library_errors(path, "PNG", "a whole grey image"), warnings.catch_warnings():
        warnings.simplefilter("error", Image.DecompressionBombWarning)
        try:
            with Image.open(path, formats=["PNG"]) as file:
                columns, rows = file.size
                if not 0 < columns * rows <= MAXIMUM_PIXELS:
                    raise refusal(path, "PNG", f"1 to {MAXIMUM_PIXELS} pixels", f"{rows} rows of {columns}")
                if file.mode not in (("1", "L") if binary else ("L",)):
                    what = "1-bit or 8-bit grey" if binary else "8-bit grey"
                    raise refusal(path, "PNG", what, f"mode {file.mode}")
                yield file
        except (Image.DecompressionBombError, Image.DecompressionBombWarning) as error:
            raise refusal(path, "PNG", f"at most {MAXIMUM_PIXELS} pixels", error) from error


def _numbers_in_text(path, texts):
    numbers = {}
    for name, kind in NUMBERS_IN_TEXT.items():
        if name in texts:
            try:
                numbers[name] = kind(texts[name])
            except ValueError as error:
                raise refusal(path, name, "a number", one_line(texts[name], 50)) from error
    return numbers
