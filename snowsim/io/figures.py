"""Figures to files, with the same bytes for the same figure."""

from pathlib import Path

from snowsim.io.files import written_whole

METADATA = {".svg": {"Date": None, "Creator": "snowsim"}, ".png": {"Software": "snowsim"}}


def write_figure(path, figure):
    """Write a matplotlib figure as SVG or PNG, told by the ending, whole or not at all, without a date."""
    suffix = Path(path).suffix
    if suffix not in METADATA:
        msg = f"{path}: expected a figure name that ends in .svg or .png"
        raise ValueError(msg)
    with written_whole(path) as aside:
        figure.savefig(aside, metadata=METADATA[suffix], bbox_inches="tight", dpi=150)
