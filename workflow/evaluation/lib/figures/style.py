"""The one style of all figures, what they share, and how they are written."""

from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt

from snowsim.echogram import SURFACE_ROW
from snowsim.io.files import written_whole
from snowsim.metrics.picks import snow_per_bin_m

# Okabe & Ito (2008), distinct for colour-blind readers too.
BLACK = "#000000"
BLUE = "#0072B2"
RED = "#D55E00"
GREEN = "#009E73"
ORANGE = "#E69F00"
PINK = "#CC79A7"
SKY = "#56B4E9"
YELLOW = "#F0E442"
# Greys: one for comparisons in the background, one for land.
GREY = "#999999"
LAND = "#EDF2F5"
SERIES = (BLUE, RED, GREEN, PINK, ORANGE, SKY, BLACK)
TRAINING_SETS = ("rd", "rd_gd", "rd_pd", "rd_pd_gd")
METHODS = ("cgan", "phy")
COLOURS = {
    "cgan": RED,
    "phy": BLUE,
    "rd": BLACK,
    "rd_gd": RED,
    "rd_pd": BLUE,
    "rd_pd_gd": GREEN,
    "gd": RED,
    "pd": BLUE,
    # Estimators.
    "paper": RED,
    "deblended": BLUE,
}
# Dashes tell lines apart in grey, too.
DASHES = {"phy": "-", "cgan": "--", "rd": "-", "rd_gd": "--", "rd_pd": "-.", "rd_pd_gd": ":"}
# Names in figures; in other names spaces replace underscores.
NAMES = {
    "cgan": "cGAN",
    "phy": "PHY",
    "rd": "RD",
    "gd": "GD",
    "pd": "PD",
    "rd_gd": "RD+GD",
    "rd_pd": "RD+PD",
    "rd_pd_gd": "RD+PD+GD",
    "psnr": "PSNR [dB]",
    "rmse": "RMSE [grey levels]",
    "ssim": "SSIM",
    "ods": "ODS",
    "ois": "OIS",
    "ap": "AP",
}
# Defaults of matplotlib for all figures.
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
mpl.rcParams.update(STYLE)
GUIDE = {"color": "0.5", "linestyle": ":", "linewidth": 1}  # style of lines that mark a level
DPI = 200
METADATA = {".svg": {"Date": None, "Creator": "snowsim"}, ".png": {"Software": "snowsim"}}
PLANTED = "planted layers, no observed data"


@dataclass(frozen=True)
class Scale:
    """Metres of snow in a range bin, and kilometres along track in a range line."""

    bin_m: float
    line_km: float

    @classmethod
    def of(cls, statistics, density_kg_m3):
        """Scale of a flight's radar in snow of one density."""
        bin_m = snow_per_bin_m(statistics.attrs["bin_size_s"], density_kg_m3)
        return cls(bin_m, statistics.attrs["line_spacing_m"] / 1e3)

    def depth_m(self, bins, surface_bin=SURFACE_ROW):
        """Depth of range bins below the surface [m]; air above it counts as snow."""
        return (bins - surface_bin) * self.bin_m

    def plot_image(self, ax, image, surface_bin=SURFACE_ROW):
        """Echogram against depth and distance, black to white from 0 to 255."""
        n_bins, n_lines = image.shape
        right = n_lines * self.line_km
        top, bottom = self.depth_m(np.array([-0.5, n_bins - 0.5]), surface_bin)
        ax.imshow(image, vmin=0, vmax=255, extent=(0, right, bottom, top))

    def plot_layers(self, ax, layer_bins, surface_bin=SURFACE_ROW, color=YELLOW):
        """Layers as thin lines against depth and distance."""
        distance_km = (np.arange(layer_bins.shape[1]) + 0.5) * self.line_km
        depth_m = self.depth_m(layer_bins.T, surface_bin)
        ax.plot(distance_km, depth_m, color=color, linewidth=0.6)


def name_of(key):
    """Name in figures of a method, a training set, a metric or a quantity."""
    return NAMES.get(key, key.replace("_", " "))


def colour_of(key):
    """Colour of a method or a training set: those of someone's own share one."""
    return COLOURS.get(key, PINK)


def line_style(key):
    """Colour, dashes and label of a method or a training set."""
    return {"color": colour_of(key), "linestyle": DASHES.get(key, "-"), "label": name_of(key)}


def new_figure(n_rows=1, n_columns=1, width=6.0, height=3.0, **keywords):
    """Figure and axes array (row, column) in the house style; sizes in inches."""
    return plt.subplots(n_rows, n_columns, figsize=(width, height), squeeze=False, **keywords)


def new_panel(width=6.0, height=3.0):
    """Figure of a single panel, and its axes."""
    figure, axes = new_figure(width=width, height=height)
    return figure, axes[0, 0]


def list_downwards(ax, names, **keywords):
    """Label rows that are drawn one below the other, the first at the top."""
    ax.set_yticks(range(len(names)), names, **keywords)
    ax.set_ylim(len(names) - 0.5, -0.5)


def evenly_spaced(numbers, n_chosen):
    """Indices of numbers at evenly spaced ranks, in that order; all if there are fewer."""
    order = np.argsort(np.asarray(numbers), kind="stable")
    ranks = np.linspace(0, order.size - 1, min(n_chosen, order.size))
    return order[np.rint(ranks).astype(int)]


def save_figure(path, figure, source):
    """Write a figure whole or not at all; a corner of it names the source of its data.

    The file holds no date, so that the same figure gives the same bytes. A figure in .svg is also
    written as .png, which comes first, so that every .svg has a .png beside it.
    """
    figure.get_layout_engine().set(rect=(0, 0.03, 1, 0.97))  # room for the source
    figure.text(0.995, 0.002, source, ha="right", va="bottom", fontsize=6, color="0.4")
    path = Path(path)
    for ending in dict.fromkeys([".png", path.suffix]):
        with written_whole(path.with_suffix(ending)) as aside:
            figure.savefig(aside, metadata=METADATA[ending], bbox_inches="tight", dpi=DPI)
    plt.close(figure)
