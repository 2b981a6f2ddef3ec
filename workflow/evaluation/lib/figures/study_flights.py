"""Study of flights: worth of training sets over flights, and the learning curve."""

import numpy as np

from evaluation.lib.figures.style import (
    BLACK,
    COLOURS,
    GREY,
    SKY,
    list_downwards,
    name_of,
    named_style,
    new_figure,
    new_panel,
)
from evaluation.lib.flights import UNIVERSAL

# Drawn scenes alone and mixed share a colour elsewhere, and a panel here.
STYLES = {
    "rd": named_style("rd"),
    "pd": {**named_style("pd"), "color": SKY},
    "rd_pd": named_style("rd_pd"),
    UNIVERSAL: {**named_style(UNIVERSAL), "linestyle": "--"},
}
FARTHEST = 1.15  # of the last number of scenes: where more than that is drawn


def flights_worth(worth, scores):
    """Difference of fused ODS of every pair: flights, and their mean with its interval."""
    figure, ax = new_panel(width=6.5, height=4)
    means = scores.groupby(["run", "flight"])["ods"].mean()
    rows = list(worth[worth["metric"] == "ods"].itertuples())
    for y, row in enumerate(rows):
        colour = BLACK if row.family == "endpoint" else COLOURS.get(row.run, GREY)
        ax.hlines(y, row.low, row.high, color=colour)
        ax.plot(row.difference, y, "D", color=colour, markersize=5)
        flights = means[row.run] - means[row.base]
        ax.plot(flights, np.full(len(flights), y), "o", color=colour, alpha=0.5, markersize=2.5)
    ax.axvline(0, color="0.5", linewidth=0.8)
    list_downwards(ax, [f"{name_of(row.run)} less {name_of(row.base)}" for row in rows])
    ax.set_xlabel("difference of ODS")
    return figure


def learning_curve(curve):
    """ODS by the number of annotated scenes, and scenes saved, a column a flight."""
    flights = list(dict.fromkeys(curve["flight"])) or [None]
    width = 3.2 * len(flights)
    figure, axes = new_figure(2, len(flights), width=width, height=5, sharex=True)
    for column, flight in enumerate(flights):
        above, below = axes[:, column]
        of_flight = curve[curve["flight"] == flight]
        annotated = of_flight[of_flight["n_scenes"] > 0]
        for name, rows in annotated.groupby("training_set", sort=False):
            draw_scores(above, rows, name)
            if name != "rd":
                draw_saved(below, rows, name)
        for row in of_flight[of_flight["n_scenes"] == 0].itertuples():
            # Without annotation, so at no place of the logarithmic axis.
            above.axhline(row.ods, **STYLES[row.training_set])
        above.set_title(f"flight {flight}")
        below.set_xscale("log", base=2)
        numbers = sorted(set(annotated["n_scenes"]))
        below.set_xticks(numbers, map(str, numbers))
        below.set_xlabel("annotated scenes")
    axes[0, 0].legend()
    axes[0, 0].set_ylabel("ODS of fuse")
    axes[1, 0].set_ylabel("annotated scenes saved")
    return figure


def draw_scores(ax, rows, name):
    """A learning curve with its intervals."""
    reach = [rows["ods"] - rows["low"], rows["high"] - rows["ods"]]
    # A mean of all trainings need not lie between percentiles of few resamples.
    reach = np.maximum(reach, 0)
    ax.errorbar(rows["n_scenes"], rows["ods"], yerr=reach, marker="o", **STYLES[name])


def draw_saved(ax, rows, name):
    """Scenes saved with their intervals; a triangle where they are more than the curve holds."""
    n = rows["n_scenes"]
    most = FARTHEST * n.max() - n
    is_known = np.isfinite(rows["saved"])
    colour = STYLES[name]["color"]
    ax.vlines(n, rows["saved_low"].clip(upper=most), rows["saved_high"].clip(upper=most), colour)
    ax.plot(n[is_known], rows["saved"][is_known], "o", **STYLES[name])
    ax.plot(n[~is_known], most[~is_known], "^", color=colour)
    ax.axhline(0, color="0.5", linewidth=0.8)
