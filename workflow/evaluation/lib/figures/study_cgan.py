"""Studies of the cGAN: cost and worth of renderers, positions of layers, healthy trainings."""

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

from evaluation.lib.figures.style import BLACK, COLOURS, name_of, new_figure

WORTH = {
    "two_sample_network": "two-sample accuracy, network",
    "ods": "ODS of a tracker trained on it alone",
}
SHAPES = {
    "height": "height [range bins]",
    "layers": "layers below the surface",
    "slope": "slope [range bins per line]",
    "spacing": "least spacing [range bins]",
}
N_CLASSES = 6


def speed_accuracy_renderers(renderers):
    """Two-sample accuracy and ODS, a dot a training, against processor time per pixel."""
    figure, axes = new_figure(1, 2, width=8)
    for ax, (column, label) in zip(axes[0], WORTH.items(), strict=True):
        for name, rows in renderers.groupby("renderer", sort=False):
            nanoseconds = 1e9 * rows["seconds_per_pixel"]
            ax.plot(nanoseconds, rows[column], "o", color=COLOURS[name], label=name_of(name))
        ax.set(xscale="log", xlabel="nanoseconds per pixel", ylabel=label)
        ax.xaxis.set_major_locator(LogLocator(subs=(1, 3)))
        ax.xaxis.set_major_formatter("{x:g}")
        ax.xaxis.set_minor_formatter(NullFormatter())
    axes[0, 0].axhline(0.5, color=BLACK, linestyle=":")
    axes[0, 1].legend()
    return figure


def atlas_positions(positions):
    """Median error of recovered layers by geometry; crosses: outside the cGAN's training."""
    figure, axes = new_figure(1, 4, width=11, sharey=True)
    drawn = positions[positions["renderer"] != "observed"]
    for ax, (column, label) in zip(axes[0], SHAPES.items(), strict=True):
        known = drawn[np.isfinite(drawn[column]) & np.isfinite(drawn["error_bins"])]
        edges = np.unique(np.quantile(known[column], np.linspace(0, 1, N_CLASSES + 1)))
        place = np.searchsorted(edges, known[column], side="right") - 1
        place = np.clip(place, 0, max(edges.size - 2, 0))
        for name, rows in known.groupby("renderer", sort=False):
            of_rows = place[known["renderer"] == name]
            medians = rows.groupby(of_rows)[[column, "error_bins"]].median()
            x = medians[column]
            ax.plot(x, medians["error_bins"], "o-", color=COLOURS[name], label=name_of(name))
        beyond = known[known["outside"] & (known["renderer"] == "cgan")]
        x = beyond[column]
        ax.plot(x, beyond["error_bins"], "x", markersize=3, color=COLOURS["cgan"], alpha=0.5)
        ax.set(xlabel=label)
    axes[0, 0].set(ylabel="position error [range bins]")
    axes[0, 0].legend()
    return figure


def atlas_cgan(atlas):
    """Share of trainings that end healthy by learning rate and L1 weight; faults of the others."""
    figure, axes = new_figure(width=5, height=3.5)
    ax = axes[0, 0]
    rates = sorted(atlas["learning_rate"].unique())
    weights = sorted(atlas["l1_weight"].unique())
    share = np.full((len(weights), len(rates)), np.nan)
    for (rate, weight), runs in atlas.groupby(["learning_rate", "l1_weight"]):
        row = weights.index(weight)
        column = rates.index(rate)
        is_healthy = runs["outcome"] == "healthy"
        share[row, column] = is_healthy.mean()
        kinds = set()
        for outcome in runs.loc[~is_healthy, "outcome"]:
            kinds |= {fault.split(":")[0] for fault in outcome.split("; ")}
        text = "\n".join([f"{is_healthy.sum()} of {len(runs)}", *sorted(kinds)])
        ax.text(column, row, text, ha="center", va="center", fontsize=5.5)
    ax.imshow(share, vmin=0, vmax=1, cmap="PuOr", alpha=0.6, origin="lower", aspect="auto")
    ax.set_xticks(range(len(rates)), [f"{rate:g}" for rate in rates])
    ax.set_yticks(range(len(weights)), [f"{weight:g}" for weight in weights])
    ax.set(xlabel="learning rate", ylabel="L1 weight")
    return figure
