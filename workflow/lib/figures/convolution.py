"""How good the convolution model is: errors against contrast, layers, lenses and layering; tails; and cost."""

import numpy as np

# Okabe & Ito (2008), as in the other figures.
COLOURS = {
    "Born": "#D55E00",
    "single scattering": "#009E73",
    "convolution": "#0072B2",
    "transfer matrix": "#000000",
    "PHY": "#0072B2",
    "PHY, literal": "#56B4E9",
    "nature run": "#999999",
    "SMRT": "#CC79A7",
}
SIMPLER = ("Born", "single scattering", "convolution")
SPECKLE_DB = 0.43  # standard deviation of the mean of 100 looks: 10 / ln 10 / sqrt(100)
LEAST_DB = 1e-3  # errors below are drawn there
ABOVE = ("Born", "PHY", "nature run", "transfer matrix")


def plot_stacks(ax, table, sweep, xlabel, scale="log"):
    """Error of the simpler models against the transfer matrix over one sweep, and the speckle of 100 looks."""
    rows = table[(table["part"] == "stacks") & (table["sweep"] == sweep)]
    for method in SIMPLER:
        line = rows[rows["method"] == method].sort_values("value")
        # Two of the lines often coincide: the wider lies below.
        width = 3 if method == "single scattering" else 1.2
        ax.plot(line["value"], line["error_db"].clip(LEAST_DB), "o-", markersize=3, color=COLOURS[method],
                linewidth=width, label=method)  # fmt: skip
    _limit(ax)
    ax.set(xscale=scale, yscale="log", xlabel=xlabel, ylabel="error [dB rms]")
    if scale == "symlog":
        ax.set_xlim(left=0)
        ticks = sorted(rows["value"].unique())
        ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])


def plot_tails(ax, table):
    """Error of the best fit of eq. (1) to tails of surface and horizon, by how far down they are followed."""
    rows = table[(table["part"] == "tail") & (table["unit"] == "dB below the peak") & (table["method"] == "PHY")]
    styles = {"surface": "o", "horizon": "s", "volume": "^"}
    for (reference, case), line in rows.groupby(["reference", "sweep"], sort=False):
        line = line.sort_values("value")
        colour = COLOURS["SMRT"] if reference == "SMRT" else COLOURS["nature run"]
        ax.plot(
            line["value"], line["error_db"].clip(LEAST_DB), f"{styles[case]}-", markersize=3, color=colour,
            label=f"{case}, {reference}",
        )  # fmt: skip
    _limit(ax)
    ax.set(yscale="log", xlabel="tail followed down to [dB below the peak]", ylabel="best fit of eq. (1) [dB rms]")
    ax.legend(frameon=False, fontsize=6)


def plot_costs(ax, table):
    """Seconds of a scene against the error that belongs to each model; the reference at the left border."""
    rows = table[table["part"] == "scene"]
    points = rows.groupby("method", sort=False).agg({"seconds": "min", "error_db": "first"})
    for method, point in points.iterrows():
        name = method.removesuffix(", stack")
        error = max(point["error_db"], LEAST_DB)
        ax.plot(error, point["seconds"], "o", color=COLOURS[name], markersize=4)
        offset = 4 if name in ABOVE else -8  # names of neighbouring points lie above and below them
        ax.annotate(name, (error, point["seconds"]), xytext=(3, offset), textcoords="offset points", fontsize=6)
    ax.set(xscale="log", yscale="log", xlabel="error of the mean [dB rms]", ylabel="seconds per scene")
    ax.set_xlim(LEAST_DB / 2, 20 * np.nanmax(points["error_db"].clip(LEAST_DB)))
    ax.axvspan(LEAST_DB / 2, 1.6 * LEAST_DB, color="0.93", zorder=0)
    ax.annotate("reference", (LEAST_DB, 0.02), xycoords=("data", "axes fraction"), fontsize=6, ha="center")


def _limit(ax):
    ax.axhline(SPECKLE_DB, color="0.5", linestyle=":", linewidth=1)
    ax.annotate("speckle of 100 looks", (0.02, SPECKLE_DB), xycoords=("axes fraction", "data"), fontsize=6,
                va="bottom", color="0.4")  # fmt: skip
    ax.set_ylim(LEAST_DB / 2, 20)
