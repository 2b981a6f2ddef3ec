"""Study of flights: worth of training sets over flights."""

from evaluation.lib.figures.style import (
    BLACK,
    COLOURS,
    GREY,
    list_downwards,
    name_of,
    new_panel,
)


def flights_worth(worth):
    """Difference of fused ODS of every pair: flights, and their mean with its interval."""
    figure, ax = new_panel(width=6.5, height=3)
    rows = worth[(worth["metric"] == "ods") & worth["base"].notna()].reset_index(drop=True)
    flights = rows.filter(like="flight_")
    for y, row in rows.iterrows():
        # The endpoint comes first.
        colour = COLOURS.get(row["training_set"], GREY) if y else BLACK
        ax.hlines(y, row["low"], row["high"], color=colour)
        ax.plot(row["mean"], y, "D", color=colour, markersize=5)
        at = [y] * len(flights.columns)
        ax.plot(flights.loc[y], at, "o", color=colour, alpha=0.5, markersize=2.5)
    ax.axvline(0, color="0.5", linewidth=0.8)
    pairs = zip(rows["training_set"], rows["base"], strict=True)
    list_downwards(ax, [f"{name_of(name)} less {name_of(base)}" for name, base in pairs])
    ax.set_xlabel("difference of ODS")
    return figure
