"""Accuracy of the convolution model: errors against contrast, layers, lenses and layering; tails; and cost."""

import numpy as np
import pandas as pd

from lib.figures.style import COLOURS, SERIES, new_figure, note_source

SWEEPS = {
    "density contrast": ("density contrast of 20 slabs [kg m-3]", "log"),
    "layers": ("slabs of the default horizon contrast", "log"),
    "ice lenses": ("ice lenses of 3 cm among 20 slabs", "symlog"),
    "fine layering": ("s.d. of fine layering [kg m-3]", "log"),
}
SIMULATED = {
    "contrast": "contrast, 3 range cells apart [kg m-3]",
    "spacing": "spacing at 250 kg m-3 [range cells]",
}
CLAIMED = {
    "error_db": ("-", 0.5),
    "delay_error_bins": ("--", 0.1),
}  # how drawn; what `snowsim.simulate` keeps
SIMPLER = ("Born", "single scattering", "convolution")
TAIL_MARKS = {"surface": "o", "horizon": "s", "volume": "^"}
SPECKLE_DB = 0.43  # standard deviation of the mean of 100 looks: 10 / ln 10 / sqrt(100)
LEAST_DB = 1e-3  # errors below are drawn there
ABOVE = ("Born", "PHY", "nature run", "transfer matrix")


def convolution_accuracy(convolution_accuracy, studies, source):
    """Errors of the convolution model by what causes them, and what each model costs; SMRT's where they were made."""
    table = pd.concat([convolution_accuracy, *studies])
    figure, axes = new_figure(3, 3, width=9.5, height=8.2)
    for ax, (sweep, (xlabel, scale)) in zip(axes.flat, SWEEPS.items(), strict=False):
        plot_stacks(ax, table, sweep, xlabel, scale)
    axes[0, 0].legend(fontsize=6, loc="upper left")
    plot_tails(axes[1, 1], table)
    plot_costs(axes[1, 2], table)
    for ax, (sweep, xlabel) in zip(axes[2], SIMULATED.items(), strict=False):
        plot_simulated(ax, table, sweep, xlabel)
    axes[2, 0].legend(fontsize=6)
    plot_decay(axes[2, 2], table)
    missing = "" if studies else "; SMRT: not run (target study_convolution)"
    return note_source(figure, f"models beside each other, settings of the {source}{missing}")


def plot_stacks(ax, table, sweep, xlabel, scale="log"):
    """Error of the simpler models against the transfer matrix over one sweep, and the speckle of 100 looks."""
    rows = table[(table["part"] == "stacks") & (table["sweep"] == sweep)]
    for method in SIMPLER:
        line = rows[rows["method"] == method].sort_values("value")
        # Two of the lines often coincide: the wider lies below.
        style = {
            "color": COLOURS[method],
            "linewidth": 3 if method == "single scattering" else 1.2,
            "label": method,
        }
        ax.plot(line["value"], line["error_db"].clip(LEAST_DB), "o-", markersize=3, **style)
    _limit(ax)
    ax.set(xscale=scale, yscale="log", xlabel=xlabel, ylabel="error [dB rms]")
    if scale == "symlog":
        ax.set_xlim(left=0)
        ticks = sorted(rows["value"].unique())
        ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])


def plot_tails(ax, table):
    """Error of the best fit of eq. (1) to tails of surface and horizon, by how far down they are followed."""
    rows = table[
        (table["part"] == "tail")
        & (table["unit"] == "dB below the peak")
        & (table["method"] == "PHY")
    ]
    for (reference, case), line in rows.groupby(["reference", "sweep"], sort=False):
        line = line.sort_values("value")
        style = {
            "color": COLOURS["SMRT" if reference == "SMRT" else "nature run"],
            "label": f"{case}, {reference}",
        }
        ax.plot(
            line["value"],
            line["error_db"].clip(LEAST_DB),
            f"{TAIL_MARKS[case]}-",
            markersize=3,
            **style,
        )
    _limit(ax)
    ax.set(
        yscale="log",
        xlabel="tail followed down to [dB below the peak]",
        ylabel="best fit of eq. (1) [dB rms]",
    )
    ax.legend(fontsize=6)


def plot_costs(ax, table):
    """Seconds of a scene against the error that belongs to each model; the reference at the left border."""
    rows = table[table["part"] == "scene"]
    points = rows.groupby("method", sort=False).agg({"seconds": "min", "error_db": "first"})
    for method, point in points.iterrows():
        name = method.removesuffix(", stack")
        at = max(point["error_db"], LEAST_DB), point["seconds"]
        ax.plot(*at, "o", color=COLOURS[name], markersize=4)
        offset = 4 if name in ABOVE else -8  # names of neighbouring points lie above and below them
        ax.annotate(name, at, xytext=(3, offset), textcoords="offset points", fontsize=6)
    ax.set(
        xscale="log", yscale="log", xlabel="error of the mean [dB rms]", ylabel="seconds per scene"
    )
    ax.set_xlim(LEAST_DB / 2, 20 * np.nanmax(points["error_db"].clip(LEAST_DB)))
    ax.axvspan(LEAST_DB / 2, 1.6 * LEAST_DB, color="0.93", zorder=0)
    ax.annotate(
        "reference", (LEAST_DB, 0.02), xycoords=("data", "axes fraction"), fontsize=6, ha="center"
    )


def plot_simulated(ax, table, sweep, xlabel):
    """Largest error of power [dB], and of delay [bins], of simulated layers against the transfer matrix, by radar."""
    rows = table[(table["part"] == "simulate") & (table["sweep"] == sweep)]
    for number, (radar, line) in enumerate(rows.groupby("method", sort=False)):
        for column, (style, claimed) in CLAIMED.items():
            label = radar if style == "-" else None
            ax.plot(
                line["value"], line[column].clip(LEAST_DB), style, color=SERIES[number], label=label
            )
            ax.axhline(claimed, color="0.5", linestyle=":", linewidth=1)
    ax.set(xscale="log", yscale="log", xlabel=xlabel, ylabel="power [dB], dashed: delay [bins]")
    ticks = sorted(rows["value"].unique())[:: 2 if sweep == "contrast" else 1]
    ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    ax.minorticks_off()
    ax.set_ylim(LEAST_DB / 2, 20)


def plot_decay(ax, table):
    """Largest error of exponential tails over 20 dB against the annuli, by slope (squares) and by beam."""
    rows = table[table["part"] == "decay"]
    for number, (case, line) in enumerate(rows.groupby("method", sort=False)):
        for sweep, marker in (("slope", "s"), ("beam", "o")):
            points = line[line["sweep"] == sweep]
            at = np.degrees(np.arctan(points["value"])) if sweep == "slope" else points["value"]
            style = {"color": SERIES[number], "markersize": 3, "label": f"{sweep}, {case}"}
            ax.plot(at, points["error_db"].clip(LEAST_DB), f"{marker}-", **style)
    ax.set(
        xscale="log",
        yscale="log",
        xlabel="rms slope or beam width [degrees]",
        ylabel="error over 20 dB [dB]",
    )
    ax.set_ylim(LEAST_DB / 2, 20)
    ax.legend(fontsize=6)


def _limit(ax):
    ax.axhline(SPECKLE_DB, color="0.5", linestyle=":", linewidth=1)
    at, style = (0.02, SPECKLE_DB), {"fontsize": 6, "va": "bottom", "color": "0.4"}
    ax.annotate("speckle of 100 looks", at, xycoords=("axes fraction", "data"), **style)
    ax.set_ylim(LEAST_DB / 2, 20)
