"""Budgets of trainings: what a score costs in processor time."""

from lib.figures.style import BLACK, COLOURS, new_figure

PANELS = {  # of each network: the data it was trained on, the score, and what it is called
    "tracker": (
        ("rd", "ods", "ODS, trained on RD"),
        ("pd", "ods", "ODS, trained on PHY's scenes alone"),
    ),
    "cgan": (("", "distance", "cGAN: distance of patches"),),
}


def budgets(tracker, cgan):
    """Scores on validation scenes against core-seconds of a training; a line: steps alone; the default is filled."""
    figure, axes = new_figure(1, 3, width=12)
    tables = {"tracker": tracker, "cgan": cgan}
    panels = (
        (tables[network], *panel) for network, of_network in PANELS.items() for panel in of_network
    )
    for ax, (table, trained_on, score, label) in zip(axes.flat, panels, strict=True):
        table = table.assign(
            change=table["change"].fillna(""), trained_on=table["trained_on"].fillna("")
        )
        rows = table[table["trained_on"] == trained_on]
        means = rows.groupby("change", sort=False)[["core_seconds", score, "n_steps"]].mean()
        steps_alone = means[
            [not name or name.startswith("n_steps") for name in means.index]
        ].sort_values("n_steps")
        ax.plot(steps_alone["core_seconds"], steps_alone[score], color=BLACK, linewidth=0.8)
        colour = COLOURS.get(trained_on, BLACK)
        ax.plot(rows["core_seconds"], rows[score], ".", color=colour, markersize=3)
        for name, mean in means.iterrows():
            at = mean["core_seconds"], mean[score]
            ax.plot(*at, "o", color=colour, markerfacecolor=colour if not name else "none")
            ax.annotate(name or "default", at, (4, 3), textcoords="offset points", fontsize=6)
        ax.set(xscale="log", xlabel="core-seconds of a training", ylabel=label)
    return figure
