"""Training of the conditional GAN, and what bounds the similarity of its renders and PHY's."""

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

from lib.figures.style import COLOURS, NAMES

PART_COLOURS = ("#000000", "#0072B2", "#56B4E9", "#E69F00", "#CC79A7")


def plot_losses(ax, losses, columns, window=50):
    """Training losses against step as running means over `window` steps, on a logarithmic axis."""
    for column in columns:
        smooth = losses[column].rolling(window, min_periods=1).mean()
        ax.semilogy(losses["step"], smooth, linewidth=1, label=column.replace("_", " "))
    ax.set(xlabel="step", ylabel="loss")
    ax.legend(fontsize=7)


def plot_validation(ax, validation, metric):
    """One similarity metric on the scenes set aside against step, the best checkpoint marked."""
    ax.plot(validation["step"], validation[metric], "o-", color=COLOURS["cgan"], markersize=3)
    best = validation.loc[validation["fitness"].idxmax()]
    ax.plot(best["step"], best[metric], "o", color="black", markersize=6, markerfacecolor="none")
    ax.set(xlabel="step", ylabel=NAMES[metric])


def plot_cases(ax, bounds, metric):
    """Similarity of both methods to the test scenes, as rendered and without single faults, and its bounds."""
    rows = bounds[(bounds["scenes"] == "test") & (bounds["depth"] == "all")]
    cases = list(dict.fromkeys(rows.loc[rows["method"] != "bound", "case"]))
    for method in ("cgan", "phy"):
        values = rows[rows["method"] == method].set_index("case")[metric].reindex(cases)
        ax.plot(values, range(len(cases)), "o", color=COLOURS[method], label=NAMES[method])
    for style, bound in zip(("-", ":"), rows[rows["method"] == "bound"].itertuples(), strict=True):
        ax.axvline(getattr(bound, metric), color="0.4", linestyle=style, linewidth=1, label=bound.case)
    ax.set_yticks(range(len(cases)), cases)
    ax.set_ylim(len(cases) - 0.5, -2)  # room for a legend
    ax.set_xlabel(NAMES[metric])


def plot_parts(ax, parts):
    """Mean square error of both methods taken apart, stacked; what is in common is left out."""
    wide = parts.pivot_table(index="method", columns="part", values="mean_square", sort=False)
    names = [name for name in wide.columns if name != "speckle in common"]
    left = np.zeros(len(wide))
    for name, colour in zip(names, PART_COLOURS, strict=True):
        ax.barh([NAMES[method] for method in wide.index], wide[name], left=left, color=colour, label=name, height=0.5)
        left = left + wide[name].to_numpy()
    ax.set_ylim(-0.5, len(wide) + 1.5)  # room for the legend
    ax.set_xlabel("mean square error [grey levels squared]")
    ax.legend(fontsize=6, loc="upper right")


def plot_annotation(ax, bounds, metric):
    """Similarity on train scenes set aside, of renders from picked layers and from all there are."""
    rows = bounds[bounds["scenes"] != "test"]
    for method, group in rows.groupby("method"):
        ax.plot(group["layers"], group[metric], "o-", color=COLOURS[method], label=NAMES[method])
    ax.set(ylabel=NAMES[metric], xlabel="layers rendered")
    ax.margins(x=0.3)


def plot_air(ax, air, quantity, label):
    """One texture of the air, observed and rendered: mean over the scenes, and their range."""
    rows = air[air["quantity"] == quantity]
    for row in rows.itertuples():
        colour = COLOURS.get(row.method, "black")
        ax.plot([row.method] * 2, [row.min, row.max], color=colour)
        ax.plot(row.method, row.mean, "o", color=colour)
    ax.set_xticks(range(len(rows)), [NAMES.get(method, method) for method in rows["method"]])
    ax.set_ylabel(label)


def plot_widths(ax, widths, metric):
    """One similarity metric against seconds per render: widths trained for equal steps and equal time, and PHY.

    A cross marks trainings in which the detectors of collapse found faults.
    """
    for mode, face, label in (("equal_steps", COLOURS["cgan"], "equal steps"), ("equal_time", "white", "equal time")):
        rows = widths[widths["mode"] == mode]
        ax.plot(rows["seconds_per_render"], rows[metric], "o:", color=COLOURS["cgan"], markerfacecolor=face,
                label=f"cGAN, {label}")  # fmt: skip
        for row in rows.itertuples():
            ax.annotate(f"{row.width}", (row.seconds_per_render, getattr(row, metric)), fontsize=7,
                        xytext=(3, 3), textcoords="offset points")  # fmt: skip
    faulty = widths[widths["n_faults"] > 0]
    ax.plot(faulty["seconds_per_render"], faulty[metric], "kx", label="collapsed")
    phy = widths[widths["method"] == "phy"]
    ax.plot(phy["seconds_per_render"], phy[metric], "D", color=COLOURS["phy"], label=NAMES["phy"])
    ax.set(xscale="log", xlabel="seconds per render", ylabel=NAMES[metric])
    ax.xaxis.set_major_locator(LogLocator(subs=(1, 3)))
    ax.xaxis.set_major_formatter("{x:g}")
    ax.xaxis.set_minor_formatter(NullFormatter())


def plot_stability(ax, stability):
    """Share of trainings that end healthy by learning rate and L1 weight, and the faults of the others."""
    rates, weights = (sorted(stability[name].unique()) for name in ("learning_rate", "l1_weight"))
    share = np.full((len(weights), len(rates)), np.nan)
    for (rate, weight), runs in stability.groupby(["learning_rate", "l1_weight"]):
        at = weights.index(weight), rates.index(rate)
        healthy = runs["verdict"] == "healthy"
        share[at] = healthy.mean()
        kinds = {fault.split(":")[0] for verdict in runs.loc[~healthy, "verdict"] for fault in verdict.split("; ")}
        text = "\n".join([f"{healthy.sum()} of {len(runs)}", *sorted(kinds)])
        ax.text(at[1], at[0], text, ha="center", va="center", fontsize=5.5)
    ax.imshow(share, vmin=0, vmax=1, cmap="PuOr", alpha=0.6, origin="lower", aspect="auto")
    ax.set_xticks(range(len(rates)), [f"{rate:g}" for rate in rates])
    ax.set_yticks(range(len(weights)), [f"{weight:g}" for weight in weights])
    ax.set(xlabel="learning rate", ylabel="L1 weight")
