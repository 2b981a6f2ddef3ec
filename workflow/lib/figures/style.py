"""The one style of all figures: colours, names, sizes, and where the data come from.

Figures to files, with the same bytes for the same figure.
"""

from pathlib import Path

import matplotlib as mpl
from matplotlib import pyplot as plt  # noqa: E402 - the backend comes first

from snowsim.io.files import written_whole

mpl.use("Agg")
mpl.rcParams["svg.hashsalt"] = "snowsim"  # otherwise names of SVG elements differ from run to run


# Okabe & Ito (2008): told apart by colour-blind readers too.
COLOURS = {
    "observed": "#000000",
    "cgan": "#D55E00",
    "phy": "#0072B2",
    "rd": "#000000",
    "rd_gd": "#D55E00",
    "rd_pd": "#0072B2",
    "rd_pd_gd": "#009E73",
}
NAMES = {
    "cgan": "cGAN",
    "phy": "PHY",
    "rd": "RD",
    "rd_gd": "RD+GD",
    "rd_pd": "RD+PD",
    "rd_pd_gd": "RD+PD+GD",
    "rmse": "RMSE",
    "psnr": "PSNR [dB]",
    "ssim": "SSIM",
    "ods": "ODS",
    "ois": "OIS",
    "ap": "AP",
    "fuse": "fuse",
    "observed": "observed",
}
STYLE = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.labelsize": 9,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8,
    "lines.linewidth": 1.3,
    "axes.linewidth": 0.8,
    "axes.prop_cycle": mpl.cycler(color=["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"]),
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.constrained_layout.use": True,
    "legend.frameon": False,
}
mpl.rcParams.update(STYLE)  # all that is drawn later on a figure, legends among it, follows too


def new_figure(n_rows=1, n_columns=1, width=6.0, height=3.0, **keywords):
    """Figure and axes array (row, column) in the house style; sizes in inches."""
    return plt.subplots(n_rows, n_columns, figsize=(width, height), squeeze=False, **keywords)


def note_source(figure, source):
    """State what the data are in a corner of the figure: every figure of synthetic data says so."""
    figure.get_layout_engine().set(rect=(0, 0.03, 1, 0.97))  # room for the line
    figure.text(0.995, 0.002, source, ha="right", va="bottom", fontsize=6, color="0.4")


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
