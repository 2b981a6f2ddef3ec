"""The one style of all figures, what they share, and how they are written."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt

from snowsim.io.files import written_whole

# Okabe & Ito (2008), distinct for colour-blind readers too.
BLACK = "#000000"
BLUE = "#0072B2"
RED = "#D55E00"
GREEN = "#009E73"
ORANGE = "#E69F00"
PINK = "#CC79A7"
SKY = "#56B4E9"
YELLOW = "#F0E442"
# Beside them: a wine, the grey of what serves as a foil, and grounds.
WINE = "#882255"
GREY = "#999999"
WHITE = "#FFFFFF"
LAND = "#EDF2F5"
SERIES = (BLUE, RED, GREEN, PINK, ORANGE, SKY, BLACK)
ZONE_COLOURS = (BLUE, GREEN, ORANGE, RED)
TRAINING_SETS = ("rd", "rd_gd", "rd_pd", "rd_pd_gd")
METHODS = ("cgan", "phy")
COLOURS = {
    # Sources of scenes, and training sets.
    "observed": BLACK,
    "cgan": RED,
    "phy": BLUE,
    "phy_constant": SKY,
    "l1": YELLOW,
    "rd": BLACK,
    "rd_gd": RED,
    "rd_pd": BLUE,
    "rd_pd_gd": GREEN,
    "gd": RED,
    "pd": BLUE,
    "universal": PINK,
    # Estimators, and spectra of label models.
    "paper": RED,
    "deblended": BLUE,
    "tabulated": BLACK,
    "white": GREY,
    "power_law": BLUE,
    "ar1": RED,
    "matern": GREEN,
    # Ways to compute waveforms.
    "exact": GREEN,
    "closed form": GREEN,
    "closed form in support": GREY,
    "naive": PINK,
    "naive closed form": PINK,
    "planned": BLUE,
    "table": BLUE,
    "table32": YELLOW,
    "nearest": SKY,
    "sampled": BLACK,
    "convolved": BLACK,
    "wrapped": GREY,
    "cut": ORANGE,
    "recursive32": RED,
    "recursive64": WINE,
    "recursive float32": RED,
    "recursive float64": WINE,
    # Ways to draw speckle.
    "looks": BLACK,
    "looks, moving": GREY,
    "gamma": GREEN,
    "gamma, moving": SKY,
    "quantile": BLUE,
    "quantile, correlated": ORANGE,
    "cube": PINK,
    "cube_open": RED,
    # Whole scenes, and models of the echo.
    "render": SKY,
    "as printed": BLACK,
    "PHY": BLUE,
    "PHY exact": GREEN,
    "PHY, as printed": SKY,
    "cGAN": PINK,
    "nature run": GREY,
    "scatterers": RED,
    "transfer matrix": BLACK,
    "single scattering": GREEN,
    "convolution": BLUE,
    "Born": RED,
    "SMRT": PINK,
}
# As figures write them; other names stand with spaces for underscores.
NAMES = {
    "cgan": "cGAN",
    "phy": "PHY",
    "phy_constant": "PHY, constant",
    "l1": "L1 U-Net",
    "rd": "RD",
    "gd": "GD",
    "pd": "PD",
    "rd_gd": "RD+GD",
    "rd_pd": "RD+PD",
    "rd_pd_gd": "RD+PD+GD",
    "rd_full": "RD, full labels",
    "rd_full_pd": "RD, full labels, +PD",
    "rd_own": "RD+own blocks",
    "universal": "tracker of the package",
    "psnr": "PSNR [dB]",
    "rmse": "RMSE",
    "ssim": "SSIM",
    "ods": "ODS",
    "ois": "OIS",
    "ap": "AP",
    "ar1": "AR(1)",
    "matern": "Matérn",
    "width_bins": "1/e width",
    "noise_power": "noise",
    "offset_bins": "offset",
    "relative_thickness_mean": "thickness / slab 0",
}
# What most figures use; some say otherwise.
STYLE = {
    "font.size": 9,
    "axes.labelsize": 9,
    "axes.titlesize": 8,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 6,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "lines.markersize": 3,
    "axes.linewidth": 0.8,
    "axes.prop_cycle": mpl.cycler(color=SERIES),
    "axes.spines.top": False,
    "axes.spines.right": False,
    "image.cmap": "gray",
    "image.aspect": "auto",
    "image.interpolation": "none",  # vector files then hold the image's own pixels
    "figure.constrained_layout.use": True,
    "svg.hashsalt": "snowsim",  # otherwise names of SVG elements differ from run to run
}
mpl.use("Agg")
mpl.rcParams.update(STYLE)  # all that is drawn later on a figure, legends among it, follows too
GUIDE = {"color": "0.5", "linestyle": ":", "linewidth": 1}  # how levels are marked
DPI = 200
RUNNING_STEPS = 50  # of means of losses
METADATA = {".svg": {"Date": None, "Creator": "snowsim"}, ".png": {"Software": "snowsim"}}
PLANTED = "planted layers, no observed data"


def name_of(key):
    """What figures call a method, a training set, a metric, a quantity."""
    name, of, n = key.partition("_of_")
    return NAMES.get(name, name.replace("_", " ")) + (f" of {n}" if of else "")


def named_style(key):
    """Colour and label of a method, a training set, a source of scenes."""
    return {"color": COLOURS[key], "label": name_of(key)}


def new_figure(n_rows=1, n_columns=1, width=6.0, height=3.0, **keywords):
    """Figure and axes array (row, column) in the house style; sizes in inches."""
    return plt.subplots(n_rows, n_columns, figsize=(width, height), squeeze=False, **keywords)


def new_panel(width=6.0, height=3.0):
    """Figure of a single panel, and its axes."""
    figure, axes = new_figure(width=width, height=height)
    return figure, axes[0, 0]


def note_source(figure, source):
    """State what the data are in a corner, unless the figure says so already; gives the figure."""
    if not figure.texts:
        figure.get_layout_engine().set(rect=(0, 0.03, 1, 0.97))  # room for the line
        figure.text(0.995, 0.002, source, ha="right", va="bottom", fontsize=6, color="0.4")
    return figure


def name_columns(ax, keys):
    """Names of what stands side by side, a column each."""
    names = [name_of(key) for key in keys]
    ax.set_xticks(range(len(names)), names, rotation=30, ha="right")


def list_downwards(ax, names, **keywords):
    """Names of what stands one below the other, a row each, the first at the top."""
    ax.set_yticks(range(len(names)), names, **keywords)
    ax.set_ylim(len(names) - 0.5, -0.5)


def plot_echogram(ax, image, title=""):
    """8-bit echogram, range down, range lines across."""
    ax.imshow(image, vmin=0, vmax=255)
    ax.set(xlabel="range line", title=title)


def plot_layers(ax, scene, title):
    """Layers of a scene as lines on the frame of its image."""
    ax.plot(scene.layer_bins.T, color=BLACK, linewidth=0.6)
    ax.set_xlim(-0.5, scene.n_range_lines - 0.5)
    ax.set_ylim(scene.n_range_bins - 0.5, -0.5)
    ax.set(xlabel="range line", title=title)


def evenly_spaced(numbers, n_chosen):
    """Indices of numbers at evenly spaced ranks, in that order; all if there are fewer."""
    order = np.argsort(np.asarray(numbers), kind="stable")
    n_chosen = min(n_chosen, order.size)
    ranks = np.linspace(0, order.size - 1, n_chosen)
    return order[np.unique(np.rint(ranks).astype(int))]


def plot_picks(ax, layer_bins):
    """Picks as thin lines over an echogram."""
    ax.plot(np.asarray(layer_bins).T, color=ORANGE, linewidth=0.6)


def write_figure(path, figure):
    """Write a figure whole or not at all, and without a date: the same bytes for the same figure.

    One in .svg is written as .png too, and first: where the .svg lies both do.
    """
    path = Path(path)
    if path.suffix not in METADATA:
        msg = f"{path}: expected a figure name that ends in .svg or .png"
        raise ValueError(msg)
    endings = [".png", ".svg"] if path.suffix == ".svg" else [".png"]
    for ending in endings:
        with written_whole(path.with_suffix(ending)) as aside:
            figure.savefig(aside, metadata=METADATA[ending], bbox_inches="tight", dpi=DPI)
    plt.close(figure)


def save_figure(path, figure, source):
    """Write a figure that says what its data are."""
    note_source(figure, source)
    write_figure(path, figure)
