"""A page from templates, and files and images as data URIs, so that it stands alone."""

import base64
import io
import json
from pathlib import Path

import jinja2
import numpy as np
import pandas as pd
from PIL import Image

from snowsim.io.files import written_whole

MEDIA_TYPES = {".svg": "image/svg+xml", ".png": "image/png", ".csv": "text/csv"}
MOST_BYTES = 400_000  # larger figures are embedded as compressed pixels


def write_page(path, folder, template, context, filters):
    """Write a page from a template, whole or not at all; an undefined name is an error."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= filters
    page = environment.get_template(template).render(context)
    with written_whole(path) as aside:
        aside.write_text(page, encoding="utf-8")


def write_json(path, value):
    """Write plain values as JSON, whole or not at all, with the same bytes for the same value."""
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)
    with written_whole(path) as aside:
        aside.write_text(text, encoding="utf-8")


def read_benchmarks(folder):
    """What Snakemake measured under ``folder/rule/...``, a row a measurement with its `rule`."""
    folder = Path(folder)
    tables = [pd.DataFrame(columns=["rule", "s", "cpu_time", "max_rss"])]
    for path in sorted(folder.rglob("*.tsv")):
        rule = path.relative_to(folder).parts[0]
        tables.append(pd.read_csv(path, sep="\t", na_values="-").assign(rule=rule))
    return pd.concat(tables[1:] or tables, ignore_index=True)


def data_uri(content, media_type):
    """Bytes as a base64 data URI of a media type."""
    text = base64.b64encode(content).decode("ascii")
    return f"data:{media_type};base64,{text}"


def file_uri(path):
    """A file as it stands, as a data URI; ValueError unless it ends in .svg, .png or .csv."""
    path = Path(path)
    if path.suffix not in MEDIA_TYPES:
        msg = f"{path}: expected a file that ends in {', '.join(MEDIA_TYPES)}"
        raise ValueError(msg)
    return data_uri(path.read_bytes(), MEDIA_TYPES[path.suffix])


def figure_uri(path, most_bytes=MOST_BYTES):
    """A figure as a data URI: as it stands, or the PNG beside it as WebP of quality 80.

    The second if it is larger than `most_bytes`.
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
    image.save(content, format="WEBP", method=4, quality=quality)
    return data_uri(content.getvalue(), "image/webp")
