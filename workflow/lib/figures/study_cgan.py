"""Studies of the cGAN: every renderer's cost and worth, positions of layers at any height, healthy trainings."""

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

from lib.figures.style import BLACK, COLOURS, name_of, new_figure

WORTH = {
    "two_sample_network": "two-sample accuracy, network",
    "ods": "ODS of a tracker trained on it alone",
}
SHAPES = {"height": "height [range bins]", "layers": "layers below the surface"}
SHAPES |= {"slope": "slope [range bins per line]", "spacing": "least spacing [range bins]"}
N_CLASSES = 6


def speed_accuracy_renderers(renderers):
    """Two-sample accuracy and ODS, a dot a training, against processor time per pixel, by renderer."""
    figure, axes = new_figure(1, 2, width=8)
    for ax, (column, label) in zip(axes[0], WORTH.items(), strict=True):
        for name, rows in renderers.groupby("renderer", sort=False):
            ax.plot(
                1e9 * rows["seconds_per_pixel"],
                rows[column],
                "o",
                color=COLOURS[name],
                label=name_of(name),
            )
        ax.set(xscale="log", xlabel="nanoseconds per pixel", ylabel=label)
        ax.xaxis.set_major_locator(LogLocator(subs=(1, 3)))
        ax.xaxis.set_major_formatter("{x:g}")
        ax.xaxis.set_minor_formatter(NullFormatter())
    axes[0, 0].axhline(0.5, color=BLACK, linestyle=":")
    axes[0, 1].legend()
    return figure


def atlas_positions(positions):
    """Median error of recovered layers by classes of a scene's geometry; crosses: outside what the cGAN trained on."""
    figure, axes = new_figure(1, 4, width=11, sharey=True)
    drawn = positions[positions["renderer"] != "observed"]
    for ax, (column, label) in zip(axes[0], SHAPES.items(), strict=True):
        known = drawn[np.isfinite(drawn[column]) & np.isfinite(drawn["error_bins"])]
        edges = np.unique(np.quantile(known[column], np.linspace(0, 1, N_CLASSES + 1)))
        place = np.clip(
            np.searchsorted(edges, known[column], side="right") - 1, 0, max(edges.size - 2, 0)
        )
        for name, rows in known.groupby("renderer", sort=False):
            means = rows.groupby(place[known["renderer"] == name])[[column, "error_bins"]].median()
            ax.plot(
                means[column], means["error_bins"], "o-", color=COLOURS[name], label=name_of(name)
            )
        beyond = known[known["outside"] & (known["renderer"] == "cgan")]
        ax.plot(
            beyond[column],
            beyond["error_bins"],
            "x",
            markersize=3,
            color=COLOURS["cgan"],
            alpha=0.5,
        )
        ax.set(xlabel=label)
    axes[0, 0].set(ylabel="position error [range bins]")
    axes[0, 0].legend()
    return figure


def atlas_cgan(atlas):
    """Share of trainings that end healthy by learning rate and L1 weight, and the faults of the others."""
    figure, axes = new_figure(width=5, height=3.5)
    ax = axes[0, 0]
    rates, weights = (sorted(atlas[name].unique()) for name in ("learning_rate", "l1_weight"))
    share = np.full((len(weights), len(rates)), np.nan)
    for (rate, weight), runs in atlas.groupby(["learning_rate", "l1_weight"]):
        at = weights.index(weight), rates.index(rate)
        healthy = runs["outcome"] == "healthy"
        share[at] = healthy.mean()
        kinds = {
            fault.split(":")[0]
            for outcome in runs.loc[~healthy, "outcome"]
            for fault in outcome.split("; ")
        }
        text = "\n".join([f"{healthy.sum()} of {len(runs)}", *sorted(kinds)])
        ax.text(at[1], at[0], text, ha="center", va="center", fontsize=5.5)
    ax.imshow(share, vmin=0, vmax=1, cmap="PuOr", alpha=0.6, origin="lower", aspect="auto")
    ax.set_xticks(range(len(rates)), [f"{rate:g}" for rate in rates])
    ax.set_yticks(range(len(weights)), [f"{weight:g}" for weight in weights])
    ax.set(xlabel="learning rate", ylabel="L1 weight")
    return figure
