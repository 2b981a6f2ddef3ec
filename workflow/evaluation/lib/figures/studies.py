"""Studies of training sets: worth over flights, by depth, by number of annotated scenes."""

from evaluation.lib.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    RED,
    list_downwards,
    new_figure,
    new_panel,
)
from evaluation.lib.studied import studied_set

ROLES = {"endpoint": BLACK, "secondary": BLUE, "exploratory": GREY}
BY_DEPTH = {
    "rd": BLACK,
    "rd_sample": GREY,
    "rd_completed": ORANGE,
    "rd_pd": BLUE,
    "rd_sample_pd": GREEN,
    "rd_gd_picked": RED,
}
FEWEST_LAYERS = 20  # of a depth step that is drawn
ALONE = {False: (BLACK, "RD alone"), True: (BLUE, "RD and PHY's scenes")}


def flights_worth(worth):
    """Difference of fused ODS of every pair: flights, and their mean with its interval."""
    rows = worth[(worth["metric"] == "ods") & worth["base"].notna()].reset_index(drop=True)
    figure, ax = new_panel(width=7.5, height=0.6 + 0.22 * len(rows))
    flights = rows.filter(like="flight_")
    for y, row in rows.iterrows():
        colour = ROLES[row["role"]]
        ax.hlines(y, row["low"], row["high"], color=colour)
        ax.plot(row["mean"], y, "D", color=colour, markersize=5)
        at = [y] * len(flights.columns)
        ax.plot(flights.loc[y], at, "o", color=colour, alpha=0.5, markersize=2.5)
    ax.axvline(0, color="0.5", linewidth=0.8)
    pairs = zip(rows["training_set"], rows["base"], rows["role"], strict=True)
    names = [f"{_about(name)} less {_about(base)} ({role})" for name, base, role in pairs]
    list_downwards(ax, names)
    ax.set_xlabel("difference of fused ODS; small: flights, large: their mean, 95 %")
    return figure


def flights_depths(depths):
    """Share of layer pixels found against depth below the surface, of the sets that were flown."""
    figure, ax = new_panel(width=6, height=3.5)
    flown = set(depths["training_set"])
    for name, colour in BY_DEPTH.items():
        if name not in flown:
            continue
        rows = depths[(depths["training_set"] == name) & (depths["n_layers"] >= FEWEST_LAYERS)]
        ax.plot("depth_from_bins", "share", data=rows, color=colour, marker="o", label=_about(name))
    ax.set(xlabel="depth below the surface, steps from [range bins]", ylim=(0, 1))
    ax.set_ylabel("share of layer pixels found")
    ax.legend(fontsize=8)
    return figure


def annotation(curve):
    """ODS against the number of annotated scenes, with and without PHY's, a panel a flight."""
    flights = list(curve["flight"].unique())
    figure, axes = new_figure(1, len(flights), width=3.6 * len(flights), height=3, sharey=True)
    for ax, flight in zip(axes[0], flights, strict=True):
        for with_pd, (colour, label) in ALONE.items():
            rows = curve[(curve["flight"] == flight) & (curve["with_pd"] == with_pd)]
            ax.fill_between("n_scenes", "low", "high", data=rows, color=colour, alpha=0.2, lw=0)
            ax.plot("n_scenes", "ods", data=rows, color=colour, marker="o", label=label)
        ax.set_xscale("log")
        n_scenes = sorted(curve["n_scenes"].unique())
        ax.set_xticks(n_scenes, [str(n) for n in n_scenes])
        ax.minorticks_off()
        ax.set(xlabel="annotated scenes", title=f"flight of seed {flight}")
    axes[0, 0].set_ylabel("fused ODS on validation scenes")
    axes[0, 0].legend(fontsize=8)
    return figure


def _about(name):
    """A training set in words."""
    return studied_set(name).about
