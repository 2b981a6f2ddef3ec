"""Accuracy of the convolution model: errors by what causes them, tails, and cost."""

import numpy as np
import pandas as pd

from evaluation.lib.figures.style import COLOURS, GUIDE, SERIES, new_figure, note_source

SWEEPS = {
    "density contrast": "density contrast of 20 slabs [kg m-3]",
    "layers": "slabs of the default horizon contrast",
    "ice lenses": "ice lenses of 3 cm among 20 slabs",
    "fine layering": "s.d. of fine layering [kg m-3]",
}
FROM_ZERO = ("ice lenses",)  # sweeps that no logarithm holds
SIMULATED = {
    "contrast": "contrast, 3 range cells apart [kg m-3]",
    "spacing": "spacing at 250 kg m-3 [range cells]",
}
CLAIMED_ERROR_DB = 0.5  # what `snowsim.simulate` keeps
CLAIMED_DELAY_BINS = 0.1
SIMPLER = ("Born", "single scattering", "convolution")
TAIL_MARKS = {"surface": "o", "horizon": "s", "volume": "^"}
SPECKLE_DB = 0.43  # standard deviation of the mean of 100 looks: 10 / ln 10 / sqrt(100)
LEAST_DB = 1e-3  # errors below are drawn there
ABOVE = ("Born", "PHY", "nature run", "transfer matrix")


def convolution_accuracy(convolution_accuracy, studies, source):
    """Errors of the convolution model by what causes them, and what each model costs.

    Errors against SMRT are drawn where its study has been made.
    """
    table = pd.concat([convolution_accuracy, *studies])
    figure, axes = new_figure(3, 3, width=9.5, height=8.2)
    for ax, (sweep, xlabel) in zip(axes.flat, SWEEPS.items(), strict=False):
        plot_stacks(ax, table, sweep, xlabel, "symlog" if sweep in FROM_ZERO else "log")
    axes[0, 0].legend(loc="upper left")
    plot_tails(axes[1, 1], table)
    plot_costs(axes[1, 2], table)
    for ax, (sweep, xlabel) in zip(axes[2], SIMULATED.items(), strict=False):
        plot_simulated(ax, table, sweep, xlabel)
    axes[2, 0].legend()
    plot_decay(axes[2, 2], table)
    missing = "" if studies else "; SMRT: not run (target study_convolution)"
    return note_source(figure, f"models beside each other, settings of the {source}{missing}")


def drawn(error):
    """Errors as a logarithmic axis shows them."""
    return error.clip(LEAST_DB)


def plot_stacks(ax, table, sweep, xlabel, scale="log"):
    """Error of the simpler models against the transfer matrix over one sweep, and speckle."""
    rows = table.query("part == 'stacks' and sweep == @sweep")
    for method in SIMPLER:
        line = rows.query("method == @method").sort_values("value")
        # Two of the lines often coincide: the wider lies below.
        width = 3 if method == "single scattering" else 1.2
        style = {"color": COLOURS[method], "linewidth": width, "label": method}
        ax.plot(line["value"], drawn(line["error_db"]), "o-", **style)
    _limit(ax)
    ax.set(xscale=scale, yscale="log", xlabel=xlabel, ylabel="error [dB rms]")
    if scale == "symlog":
        ax.set_xlim(left=0)
        _tick_values(ax, sorted(rows["value"].unique()))


def plot_tails(ax, table):
    """Error of the best fit of eq. (1) to tails, by how far they are followed."""
    rows = table.query("part == 'tail' and unit == 'dB below the peak' and method == 'PHY'")
    for (reference, case), line in rows.groupby(["reference", "sweep"], sort=False):
        line = line.sort_values("value")
        colour = COLOURS["SMRT" if reference == "SMRT" else "nature run"]
        marks = f"{TAIL_MARKS[case]}-"
        label = f"{case}, {reference}"
        ax.plot(line["value"], drawn(line["error_db"]), marks, color=colour, label=label)
    _limit(ax)
    ax.set_yscale("log")
    ax.set_xlabel("tail followed down to [dB below the peak]")
    ax.set_ylabel("best fit of eq. (1) [dB rms]")
    ax.legend()


def plot_costs(ax, table):
    """Seconds of a scene against the error of each model; the reference at the left border."""
    rows = table.query("part == 'scene'")
    points = rows.groupby("method", sort=False).agg({"seconds": "min", "error_db": "first"})
    points["error_db"] = drawn(points["error_db"]).fillna(LEAST_DB)
    for method, seconds, error_db in points.itertuples():
        name = method.removesuffix(", stack")
        at = (error_db, seconds)
        ax.plot(*at, "o", color=COLOURS[name], markersize=4)
        offset = 4 if name in ABOVE else -8  # names of neighbouring points lie above and below them
        ax.annotate(name, at, xytext=(3, offset), textcoords="offset points", fontsize=6)
    ax.set(xscale="log", yscale="log")
    ax.set(xlabel="error of the mean [dB rms]", ylabel="seconds per scene")
    ax.set_xlim(LEAST_DB / 2, 20 * points["error_db"].max())
    ax.axvspan(LEAST_DB / 2, 1.6 * LEAST_DB, color="0.93", zorder=0)
    foot = ("data", "axes fraction")
    ax.annotate("reference", (LEAST_DB, 0.02), xycoords=foot, fontsize=6, ha="center")


def plot_simulated(ax, table, sweep, xlabel):
    """Largest errors of power and delay of simulated layers against the transfer matrix."""
    rows = table.query("part == 'simulate' and sweep == @sweep")
    for number, (radar, line) in enumerate(rows.groupby("method", sort=False)):
        colour = SERIES[number]
        ax.plot(line["value"], drawn(line["error_db"]), color=colour, label=radar)
        ax.axhline(CLAIMED_ERROR_DB, **GUIDE)
        ax.plot(line["value"], drawn(line["delay_error_bins"]), "--", color=colour)
        ax.axhline(CLAIMED_DELAY_BINS, **GUIDE)
    ax.set(xscale="log", yscale="log", xlabel=xlabel, ylabel="power [dB], dashed: delay [bins]")
    values = sorted(rows["value"].unique())
    _tick_values(ax, values[::2] if sweep == "contrast" else values)
    ax.minorticks_off()
    ax.set_ylim(LEAST_DB / 2, 20)


def plot_decay(ax, table):
    """Largest error of exponential tails over 20 dB against the annuli, by slope and by beam."""
    rows = table.query("part == 'decay'")
    for number, (case, line) in enumerate(rows.groupby("method", sort=False)):
        for sweep, marks in {"slope": "s-", "beam": "o-"}.items():
            points = line.query("sweep == @sweep")
            degrees = points["value"]
            if sweep == "slope":
                degrees = np.degrees(np.arctan(points["value"]))
            style = {"color": SERIES[number], "label": f"{sweep}, {case}"}
            ax.plot(degrees, drawn(points["error_db"]), marks, **style)
    ax.set(xscale="log", yscale="log")
    ax.set(xlabel="rms slope or beam width [degrees]", ylabel="error over 20 dB [dB]")
    ax.set_ylim(LEAST_DB / 2, 20)
    ax.legend()


def _tick_values(ax, values):
    ax.set_xticks(values, [f"{value:g}" for value in values])


def _limit(ax):
    ax.axhline(SPECKLE_DB, **GUIDE)
    left = {"xycoords": ("axes fraction", "data"), "va": "bottom"}
    ax.annotate("speckle of 100 looks", (0.02, SPECKLE_DB), fontsize=6, color="0.4", **left)
    ax.set_ylim(LEAST_DB / 2, 20)
