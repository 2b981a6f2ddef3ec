"""Studies of the cGAN: similarity against seconds by width, and which trainings end healthy."""

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

from lib.figures.style import BLACK, COLOURS, WHITE, name_of, new_figure

MODES = {"equal_steps": ("cGAN, equal steps", COLOURS["cgan"]), "equal_time": ("cGAN, equal time", WHITE)}


def speed_accuracy_cgan(widths):
    """Similarity against seconds per render by width, and PHY; crosses: trainings that detectors of collapse fault."""
    figure, axes = new_figure(1, 3, width=9)
    for ax, metric in zip(axes[0], ("psnr", "ssim", "rmse"), strict=True):
        for mode, (label, face) in MODES.items():
            rows = widths[widths["mode"] == mode]
            style = {"color": COLOURS["cgan"], "markerfacecolor": face, "label": label}
            ax.plot(rows["seconds_per_render"], rows[metric], "o:", **style)
            for row in rows.itertuples():
                at = (row.seconds_per_render, getattr(row, metric))
                ax.annotate(f"{row.width}", at, fontsize=7, xytext=(3, 3), textcoords="offset points")
        faulty, phy = widths[widths["n_faults"] > 0], widths[widths["method"] == "phy"]
        ax.plot(faulty["seconds_per_render"], faulty[metric], "x", color=BLACK, label="collapsed")
        ax.plot(phy["seconds_per_render"], phy[metric], "D", color=COLOURS["phy"], label=name_of("phy"))
        ax.set(xscale="log", xlabel="seconds per render", ylabel=name_of(metric))
        ax.xaxis.set_major_locator(LogLocator(subs=(1, 3)))
        ax.xaxis.set_major_formatter("{x:g}")
        ax.xaxis.set_minor_formatter(NullFormatter())
    axes[0, 0].legend(fontsize=7)
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
        kinds = {fault.split(":")[0] for outcome in runs.loc[~healthy, "outcome"] for fault in outcome.split("; ")}
        text = "\n".join([f"{healthy.sum()} of {len(runs)}", *sorted(kinds)])
        ax.text(at[1], at[0], text, ha="center", va="center", fontsize=5.5)
    ax.imshow(share, vmin=0, vmax=1, cmap="PuOr", alpha=0.6, origin="lower", aspect="auto")
    ax.set_xticks(range(len(rates)), [f"{rate:g}" for rate in rates])
    ax.set_yticks(range(len(weights)), [f"{weight:g}" for weight in weights])
    ax.set(xlabel="learning rate", ylabel="L1 weight")
    return figure
