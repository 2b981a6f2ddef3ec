"""Figures to files, with the same bytes for the same figure."""

from pathlib import Path

from snowsim.io.files import written_whole

DPI = 200
METADATA = {".svg": {"Date": None, "Creator": "snowsim"}, ".png": {"Software": "snowsim"}}


def write_figure(path, figure):
    """Write a matplotlib figure without a date, whole or not at all.

    A name in .svg is what rules declare: the same figure as PNG is written beside it, and before it, so that where the
    one lies the other does too. A name in .png writes that alone. ValueError for any other ending.
    """
    suffix = Path(path).suffix
    if suffix not in METADATA:
        msg = f"{path}: expected a figure name that ends in .svg or .png"
        raise ValueError(msg)
    for ending in (".png", ".svg") if suffix == ".svg" else (suffix,):
        with written_whole(Path(path).with_suffix(ending)) as aside:
            figure.savefig(aside, metadata=METADATA[ending], bbox_inches="tight", dpi=DPI)
