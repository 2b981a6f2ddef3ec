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
ANY_GREY = "grey of 1, 8 or 16 bits, or of three equal colours"
# As Pillow calls them.
MODES = {"8-bit grey": ("L",), ANY_GREY: ("1", "L", "I;16", "RGB", "RGBA")}


def read_image(path, expected="8-bit grey"):
    """PNG image (range_bin, range_line), uint8 or of 1 bit, and the `NUMBERS_IN_TEXT` it holds.

    `expected` is one of `MODES`. What is no whole PNG image of such a mode and a bearable size is
    refused.
    """
    path = existing(path)
    largest = f"{MAXIMUM_PIXELS} pixels"
    with library_errors(path, "PNG", "a whole grey image"), warnings.catch_warnings():
        warnings.simplefilter("error", Image.DecompressionBombWarning)
        try:
            Image.open(path, formats=["PNG"]).verify()  # checksums: reading does not look at them
            with Image.open(path, formats=["PNG"]) as file:
                columns, rows = file.size
                if not 0 < columns * rows <= MAXIMUM_PIXELS:
                    raise refusal(path, "PNG", f"1 to {largest}", f"{rows} rows of {columns}")
                if file.mode not in MODES[expected]:
                    raise refusal(path, "PNG", expected, f"mode {file.mode}")
                return _grey(path, np.array(file)), _numbers_in_text(path, file.text)
        except (Image.DecompressionBombError, Image.DecompressionBombWarning) as error:
            raise refusal(path, "PNG", f"at most {largest}", error) from error


def _grey(path, values):
    """Grey levels (range_bin, range_line) of an image; of colours, all equal, one."""
    if values.ndim == 3:
        colours = values[..., :3]
        if (colours != colours[..., :1]).any():
            raise refusal(path, "PNG", ANY_GREY, "colours")
        return colours[..., 0]
    return values


def read_mask(path):
    """Mask of a PNG image, bool (range_bin, range_line): 0 and one more grey level."""
    values, _ = read_image(path, ANY_GREY)
    levels = np.unique(values)
    if levels.size > 2 or (levels.size == 2 and levels[0] != 0):
        found = f"{levels.size} levels from {levels[0]} to {levels[-1]}"
        raise refusal(path, "mask", "1 bit, or two grey levels of which one is 0", found)
    return values > 0


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
    """Write a PNG, whole or not at all, with numbers as text chunks.

    Settings are fixed: same pixels, same bytes.
    """
    info = PngInfo()
    for name, number in (numbers or {}).items():
        info.add_text(name, repr(NUMBERS_IN_TEXT[name](number)))
    buffer = io.BytesIO()
    picture = Image.fromarray(np.ascontiguousarray(image))
    picture.save(buffer, format="PNG", compress_level=6, pnginfo=info)
    with written_whole(path) as aside:
        aside.write_bytes(buffer.getvalue())
