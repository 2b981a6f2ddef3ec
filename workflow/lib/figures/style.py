"""The one style of all figures, what they share, and how they are written: the same bytes for the same figure."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt

from snowsim.io.files import written_whole

# Okabe & Ito (2008), distinct for colour-blind readers too; a wine, and the grey of what serves as
# a foil.
BLACK, BLUE, RED, GREEN, ORANGE = "#000000", "#0072B2", "#D55E00", "#009E73", "#E69F00"
PINK, SKY, YELLOW, WINE, GREY, WHITE, LAND = (
    "#CC79A7",
    "#56B4E9",
    "#F0E442",
    "#882255",
    "#999999",
    "#FFFFFF",
    "#EDF2F5",
)
SERIES = (BLUE, RED, GREEN, PINK, ORANGE, SKY, BLACK)
ZONE_COLOURS = (BLUE, GREEN, ORANGE, RED)
TRAINING_SETS = ("rd", "rd_gd", "rd_pd", "rd_pd_gd")
METHODS = ("cgan", "phy")
# Sources, training sets, estimators and label models; then ways to compute waveforms, speckle and
# scenes.
COLOURS = {
    **dict.fromkeys(("observed", "rd", "tabulated"), BLACK),
    **dict.fromkeys(("looks", "as printed", "convolved", "sampled", "transfer matrix"), BLACK),
    **dict.fromkeys(("cgan", "rd_gd", "gd", "paper", "ar1"), RED),
    **dict.fromkeys(("recursive float32", "recursive32", "cube_open", "scatterers", "Born"), RED),
    **dict.fromkeys(("phy", "rd_pd", "pd", "deblended", "power_law"), BLUE),
    **dict.fromkeys(("PHY", "table", "planned", "quantile", "convolution"), BLUE),
    **dict.fromkeys(("rd_pd_gd", "matern"), GREEN),
    **dict.fromkeys(("exact", "gamma", "closed form", "PHY exact", "single scattering"), GREEN),
    **dict.fromkeys(("render", "gamma, moving", "nearest", "PHY, as printed"), SKY),
    **dict.fromkeys(
        ("white", "looks, moving", "closed form in support", "wrapped", "nature run"), GREY
    ),
    **dict.fromkeys(("cube", "naive", "naive closed form", "cGAN", "SMRT"), PINK),
    **dict.fromkeys(("recursive float64", "recursive64"), WINE),
    **dict.fromkeys(("quantile, correlated", "cut"), ORANGE),
    **dict.fromkeys(("table32", "l1"), YELLOW),
    "phy_constant": SKY,
}
# As figures write them; other names stand with spaces for underscores.
NAMES = {
    "cgan": "cGAN",
    "phy": "PHY",
    "rd_gd": "RD+GD",
    "rd_pd": "RD+PD",
    "rd_pd_gd": "RD+PD+GD",
    "psnr": "PSNR [dB]",
}
NAMES |= {name: name.upper() for name in ("rd", "gd", "pd", "rmse", "ssim", "ods", "ois", "ap")}
NAMES |= {"phy_constant": "PHY, constant", "l1": "L1 U-Net"}
NAMES |= {"ar1": "AR(1)", "matern": "Matérn", "width_bins": "1/e width", "noise_power": "noise"}
NAMES |= {"offset_bins": "offset", "relative_thickness_mean": "thickness / slab 0"}
STYLE = {
    **dict.fromkeys(("font.size", "axes.titlesize", "axes.labelsize"), 9),
    **dict.fromkeys(("xtick.labelsize", "ytick.labelsize", "legend.fontsize"), 8),
    **{"lines.linewidth": 1.3, "axes.linewidth": 0.8, "axes.prop_cycle": mpl.cycler(color=SERIES)},
    **dict.fromkeys(("axes.spines.top", "axes.spines.right", "legend.frameon"), False),
    "figure.constrained_layout.use": True,
    "svg.hashsalt": "snowsim",  # otherwise names of SVG elements differ from run to run
}
mpl.use("Agg")
mpl.rcParams.update(STYLE)  # all that is drawn later on a figure, legends among it, follows too
DPI = 200
RUNNING_STEPS = 50  # of means of losses
METADATA = {".svg": {"Date": None, "Creator": "snowsim"}, ".png": {"Software": "snowsim"}}
PLANTED = "planted layers, no observed data"


def name_of(key):
    """What figures call a method, a training set, a metric, a quantity."""
    return NAMES.get(key, key.replace("_", " "))


def new_figure(n_rows=1, n_columns=1, width=6.0, height=3.0, **keywords):
    """Figure and axes array (row, column) in the house style; sizes in inches."""
    return plt.subplots(n_rows, n_columns, figsize=(width, height), squeeze=False, **keywords)


def note_source(figure, source):
    """State what the data are in a corner of the figure, unless it says so already; gives the figure."""
    if not figure.texts:
        figure.get_layout_engine().set(rect=(0, 0.03, 1, 0.97))  # room for the line
        figure.text(0.995, 0.002, source, ha="right", va="bottom", fontsize=6, color="0.4")
    return figure


def name_columns(ax, keys):
    """Names of what stands side by side, a column each."""
    ax.set_xticks(range(len(keys)), [name_of(key) for key in keys], rotation=30, ha="right")


def plot_echogram(ax, image, title=""):
    """8-bit echogram, range down, range lines across."""
    # Uninterpolated: vector files then hold the image's own pixels.
    ax.imshow(image, vmin=0, vmax=255, cmap="gray", aspect="auto", interpolation="none")
    ax.set_xlabel("range line")
    ax.set_title(title, fontsize=8)


def plot_layers(ax, scene, title):
    """Layers of a scene as lines on the frame of its image."""
    ax.plot(scene.layer_bins.T, color=BLACK, linewidth=0.6)
    ax.set(
        xlim=(-0.5, scene.n_range_lines - 0.5),
        ylim=(scene.n_range_bins - 0.5, -0.5),
        xlabel="range line",
    )
    ax.set_title(title, fontsize=8)


def evenly_spaced(numbers, n_chosen):
    """Indices of numbers at evenly spaced ranks, in that order; all if there are fewer."""
    order = np.argsort(np.asarray(numbers), kind="stable")
    return order[
        np.unique(np.rint(np.linspace(0, order.size - 1, min(n_chosen, order.size))).astype(int))
    ]


def plot_picks(ax, layer_bins):
    """Picks as thin lines over an echogram."""
    ax.plot(np.asarray(layer_bins).T, color=ORANGE, linewidth=0.6)


def write_figure(path, figure):
    """Write a figure without a date, whole or not at all; one in .svg as .png too, and first: where it lies both do."""
    suffix = Path(path).suffix
    if suffix not in METADATA:
        msg = f"{path}: expected a figure name that ends in .svg or .png"
        raise ValueError(msg)
    for ending in (".png", ".svg") if suffix == ".svg" else (suffix,):
        with written_whole(Path(path).with_suffix(ending)) as aside:
            figure.savefig(aside, metadata=METADATA[ending], bbox_inches="tight", dpi=DPI)
    plt.close(figure)
