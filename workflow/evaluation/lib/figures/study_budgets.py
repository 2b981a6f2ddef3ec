"""Budgets of trainings: what a score costs in processor time."""

from evaluation.lib.figures.style import BLACK, COLOURS, new_figure


def budgets(tracker, cgan):
    """Scores on validation scenes against core-seconds of a training.

    A line: steps alone; the default is filled.
    """
    figure, axes = new_figure(1, 3, width=12)
    on_real, on_drawn, of_cgan = axes.flat
    plot_budget(on_real, tracker.query("trained_on == 'rd'"), "ods", COLOURS["rd"])
    on_real.set_ylabel("ODS, trained on RD")
    plot_budget(on_drawn, tracker.query("trained_on == 'pd'"), "ods", COLOURS["pd"])
    on_drawn.set_ylabel("ODS, trained on PHY's scenes alone")
    plot_budget(of_cgan, cgan, "distance", corner="upper right")
    of_cgan.set_ylabel("cGAN: distance of patches")
    return figure


def plot_budget(ax, rows, score, colour=BLACK, *, corner="lower right"):
    """One score of one network by what differs from the default: trainings, and numbered means."""
    changes = rows["change"].fillna("default")
    means = rows.groupby(changes, sort=False)[["core_seconds", score, "n_steps"]].mean()
    is_steps_alone = means.index.str.match("default|n_steps")
    steps_alone = means[is_steps_alone].sort_values("n_steps")
    ax.plot("core_seconds", score, data=steps_alone, color=BLACK, linewidth=0.8, label="_")
    ax.plot("core_seconds", score, ".", data=rows, color=colour, label="_")
    for number, (name, seconds, mean, _) in enumerate(means.itertuples(), start=1):
        filling = colour if name == "default" else "none"
        label = f"{number}  {name}"
        ax.plot(seconds, mean, "o", color=colour, markerfacecolor=filling, label=label)
        ax.annotate(number, (seconds, mean), (3, 4), textcoords="offset points", fontsize=7)
    ax.legend(loc=corner, fontsize=6, handlelength=0, markerscale=0, frameon=False)
    ax.set(xscale="log", xlabel="core-seconds of a training")
