"""Grey PNG images, read and written, and the numbers that travel in their text chunks."""

import io
import warnings

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from snowsim.io.files import write_bytes
from snowsim.io.guard import Refused, library_errors, refusal

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
    most = f"PNG: expected a whole grey image of at most {MAXIMUM_PIXELS} pixels"
    with library_errors(path, most), warnings.catch_warnings():
        warnings.simplefilter("error", Image.DecompressionBombWarning)
        Image.open(path, formats=["PNG"]).verify()  # checksums: reading does not look at them
        with Image.open(path, formats=["PNG"]) as file:
            columns, rows = file.size
            if columns * rows > MAXIMUM_PIXELS:
                msg = f"{most}, found {rows} rows of {columns}"
                raise Refused(msg)
            values = np.array(file)
            texts = file.text
            colours = values[..., :3] if values.ndim == 3 else values[..., None]
            if file.mode not in MODES[expected] or (colours != colours[..., :1]).any():
                msg = f"PNG: expected {expected}, found mode {file.mode}"
                raise Refused(msg)
        held = {name: kind for name, kind in NUMBERS_IN_TEXT.items() if name in texts}
        numbers = {name: kind(texts[name]) for name, kind in held.items()}
    return colours[..., 0], numbers


def read_mask(path):
    """Mask of a PNG image, bool (range_bin, range_line): 0 and one more grey level."""
    values, _ = read_image(path, ANY_GREY)
    levels = np.unique(values)
    if levels.size > 2 or (levels.size == 2 and levels[0] != 0):
        found = f"{levels.size} levels from {levels[0]} to {levels[-1]}"
        raise refusal(path, "mask", "1 bit, or two grey levels of which one is 0", found)
    return values > 0


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
    write_bytes(path, buffer.getvalue())
