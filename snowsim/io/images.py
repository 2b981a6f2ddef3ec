"""Grey PNG images, read and written, and the numbers that travel in their text chunks."""

import io
import warnings

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from snowsim.io.files import written_whole
from snowsim.io.guard import existing, library_errors, one_line, refusal

MAXIMUM_PIXELS = 2**26  # 256 columns of 262144 rows; below the size at which Pillow itself warns
NUMBERS_IN_TEXT = {"noise_floor_db": float, "maximum_db": float, "zone": int}


def read_image(path, *, binary=False):
    """Grey PNG image as uint8 (range_bin, range_line), and the `NUMBERS_IN_TEXT` its text chunks hold.

    With `binary`, a mask is expected, 1-bit or of two grey levels of which one is 0, and returned
    as bool; with None, what there is, 1-bit or 8-bit. What is no whole, grey PNG image of a
    bearable size is refused.
    """
    path = existing(path)
    with library_errors(path, "PNG", "a whole grey image"), warnings.catch_warnings():
        warnings.simplefilter("error", Image.DecompressionBombWarning)
        try:
            with Image.open(path, formats=["PNG"]) as file:
                columns, rows = file.size
                if not 0 < columns * rows <= MAXIMUM_PIXELS:
                    raise refusal(
                        path, "PNG", f"1 to {MAXIMUM_PIXELS} pixels", f"{rows} rows of {columns}"
                    )
                if file.mode not in (("L",) if binary is False else ("1", "L")):
                    what = "8-bit grey" if binary is False else "1-bit or 8-bit grey"
                    raise refusal(path, "PNG", what, f"mode {file.mode}")
                values = np.array(file)
                texts = _numbers_in_text(path, file.text)
        except (Image.DecompressionBombError, Image.DecompressionBombWarning) as error:
            raise refusal(path, "PNG", f"at most {MAXIMUM_PIXELS} pixels", error) from error
    if not binary:
        return values, texts
    levels = np.unique(values)
    if levels.size > 2 or (levels.size == 2 and levels[0] != 0):
        found = f"{levels.size} levels from {levels[0]} to {levels[-1]}"
        raise refusal(path, "mask", "1 bit, or two grey levels of which one is 0", found)
    return values > 0, texts


def _numbers_in_text(path, texts):
    numbers = {}
    for name, kind in NUMBERS_IN_TEXT.items():
        if name in texts:
            try:
                numbers[name] = kind(texts[name])
            except ValueError as error:
                raise refusal(path, name, "a number", one_line(texts[name], 50)) from error
    return numbers


def write_image(path, image, numbers=None):
    """Write a PNG, whole or not at all, with numbers as text chunks; fixed settings: same pixels, same bytes."""
    info = PngInfo()
    for name, number in (numbers or {}).items():
        info.add_text(name, repr(NUMBERS_IN_TEXT[name](number)))
    buffer = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(image)).save(
        buffer, format="PNG", compress_level=6, pnginfo=info
    )
    with written_whole(path) as aside:
        aside.write_bytes(buffer.getvalue())
