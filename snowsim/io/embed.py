"""Files and images as data URIs, for pages that stand alone."""

import base64
import io
from pathlib import Path

import numpy as np
from PIL import Image

MEDIA_TYPES = {".svg": "image/svg+xml", ".png": "image/png", ".csv": "text/csv"}
MOST_BYTES = 400_000  # larger figures are embedded as compressed pixels
WEBP = {"format": "WEBP", "method": 4}


def data_uri(content, media_type):
    """Bytes as a base64 data URI of a media type."""
    return f"data:{media_type};base64,{base64.b64encode(content).decode('ascii')}"


def file_uri(path):
    """A file as it stands, as a data URI; ValueError unless it ends in .svg, .png or .csv."""
    path = Path(path)
    if path.suffix not in MEDIA_TYPES:
        msg = f"{path}: expected a file that ends in {', '.join(MEDIA_TYPES)}"
        raise ValueError(msg)
    return data_uri(path.read_bytes(), MEDIA_TYPES[path.suffix])


def figure_uri(path, most_bytes=MOST_BYTES):
    """A figure as a data URI: as it stands, or if larger than `most_bytes` its pixels as WebP of quality 80.

    The pixels of an SVG figure are those of the PNG that `snowsim.io.figures.write_figure` leaves beside it.
    """
    path = Path(path)
    pixels = path.with_suffix(".png")
    if path.stat().st_size <= most_bytes or not pixels.exists():
        return file_uri(path)
    with Image.open(pixels) as image:
        return _webp(image.convert("RGB"), quality=80)


def image_uri(image, quality=65):
    """An 8-bit grey image, (row, column), as a WebP data URI; lossy, for looking at."""
    image = np.asarray(image)
    if image.dtype != np.uint8 or image.ndim != 2:
        msg = f"image must be uint8 and 2-D, got {image.dtype} of shape {image.shape}"
        raise ValueError(msg)
    return _webp(Image.fromarray(image), quality=quality)


def _webp(image, quality):
    content = io.BytesIO()
    image.save(content, quality=quality, **WEBP)
    return data_uri(content.getvalue(), "image/webp")
