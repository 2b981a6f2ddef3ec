"""Similarity of renders to observed scenes, what bounds it, layer positions, and texture."""

import numpy as np

from evaluation.lib.figures.style import (
    BLACK,
    BLUE,
    COLOURS,
    GUIDE,
    METHODS,
    ORANGE,
    PINK,
    SKY,
    name_of,
    named_style,
    new_figure,
    new_panel,
    plot_echogram,
    plot_layers,
)
from snowsim.echogram import SURFACE_ROW

N_SCENES_SHOWN = 3
PART_COLOURS = (BLACK, BLUE, SKY, ORANGE, PINK)  # of the mean square error
# Axes of what is counted in drawn and observed scenes.
SCENE_NUMBERS = {
    "contrast of layers": {
        "xlabel": "layer below the surface",
        "ylabel": "contrast of labelled layers [dB]",
    },
    "structure function, slabs": {
        "xlabel": "lag [range lines]",
        "ylabel": "structure function of slabs [bins²]",
        "xscale": "log",
        "yscale": "log",
    },
    "structure function, layers": {
        "xlabel": "lag [range lines]",
        "ylabel": "structure function of layers [bins²]",
        "xscale": "log",
        "yscale": "log",
    },
    "autocorrelation, range_line": {
        "xlabel": "lag [range lines]",
        "ylabel": "autocorrelation along track",
        "xscale": "log",
    },
    "autocorrelation, range_bin": {
        "xlabel": "lag [range bins]",
        "ylabel": "autocorrelation down range",
        "xscale": "log",
    },
}


def similarity_boxplots(images):
    """The three metrics of every method as box plots."""
    figure, axes = new_figure(1, 3, width=7)
    methods = sorted(images["method"].unique())
    style = {"widths": 0.5, "flierprops": {"marker": ".", "markersize": 4}}
    names = [name_of(method) for method in methods]
    for ax, metric in zip(axes.flat, ("ssim", "psnr", "rmse"), strict=True):
        finite = images[np.isfinite(images[metric])]
        values = [finite.query("method == @method")[metric] for method in methods]
        drawn = ax.boxplot(values, tick_labels=names, **style)
        for box, median, method in zip(drawn["boxes"], drawn["medians"], methods, strict=True):
            box.set_color(COLOURS[method])
            median.set(color=COLOURS[method], linewidth=2)
        ax.set_ylabel(name_of(metric))
    axes[0, 2].set_ylabel("RMSE [grey levels]")
    return figure


def ssim_depth(ssim_depth):
    """SSIM against range bin, smoothed, the surface marked."""
    figure, ax = new_panel()
    for method, rows in ssim_depth.groupby("method"):
        row = rows["range_bin"]
        ax.plot(row, rows["ssim"], color=COLOURS[method], alpha=0.25, linewidth=0.7)
        ax.plot(row, rows["ssim_smooth"], **named_style(method))
    ax.axvline(SURFACE_ROW, **GUIDE)
    at_top = {"xycoords": ("data", "axes fraction"), "va": "top"}
    beside = {"xytext": (4, 0), "textcoords": "offset points"}
    ax.annotate("snow surface", (SURFACE_ROW, 0.98), fontsize=7, **at_top, **beside)
    ax.set(xlabel="range bin", ylabel="SSIM")
    ax.legend(fontsize=8)
    return figure


def sample(observed, cgan, phy, images):
    """Observed scene, its layers, and both renders, for scenes at the quartiles of cGAN's SSIM."""
    ranked = images.query("method == 'cgan'").sort_values(["ssim", "scene"])["scene"].to_list()
    ranks = np.linspace(0, len(ranked) - 1, N_SCENES_SHOWN + 2)[1:-1]
    names = [ranked[round(rank)] for rank in ranks]
    figure, axes = new_figure(len(names), 4, width=8, height=2.6 * len(names))
    first, second, third, fourth = axes.T
    plot_images(first, names, observed, "observed")
    plot_images(third, names, cgan, "cGAN")
    plot_images(fourth, names, phy, "PHY")
    shown = {scene.name: scene for scene in observed if scene.name in names}
    for ax, name in zip(second, names, strict=True):
        plot_layers(ax, shown[name], f"layers of {name}")
    for ax in first:
        ax.set_ylabel("range bin")
    return figure


def plot_images(axes, names, scenes, title):
    """Scenes of some names, one below the other."""
    shown = {scene.name: scene.image for scene in scenes if scene.name in names}
    for ax, name in zip(axes, names, strict=True):
        plot_echogram(ax, shown[name], title)


def render_positions(render_positions):
    """Distance from layers to the peak near them: means over scenes, two standard errors."""
    figure, axes = new_figure(1, 2, width=8, height=3.2, sharey=True)
    units = {"slope": "range bins per range line", "curvature": "range bins per range line²"}
    for ax, (against, unit) in zip(axes[0], units.items(), strict=True):
        chosen = render_positions.query("against == @against")
        for k, (method, rows) in enumerate(chosen.groupby("method")):
            groups = rows.groupby("shape_class")["mean_abs_error_bins"]
            mean = groups.mean()
            error = 2 * groups.std() / np.sqrt(groups.count())
            at = mean.index + 0.08 * (k - 1)
            ax.errorbar(at, mean, error, fmt="o-", markersize=4, **named_style(method))
        edges = chosen.drop_duplicates("shape_class").sort_values("shape_class")
        labels = map(range_in_words, edges["shape_low"], edges["shape_high"])
        ax.set_xticks(range(len(edges)), list(labels), fontsize=7)
        ax.set(xlabel=f"{against} [{unit}]", ylim=(0, None))
    left = axes[0, 0]
    left.set_ylabel("distance to the peak [range bins]")
    left.legend(loc="lower left", fontsize=8)
    return figure


def range_in_words(low, high):
    """A range from zero, to infinity, or between two numbers."""
    if low == 0:
        return f"below {high:.2g}"
    if np.isinf(high):
        return f"above {low:.2g}"
    return f"{low:.2g} to {high:.2g}"


def similarity_bounds(similarity_bounds, similarity_parts, air_texture):
    """Bounds of similarity and what keeps renders from them, annotation, and texture in the air."""
    figure, axes = new_figure(2, 3, width=10, height=5.5)
    of_parts, of_layers, of_air = axes[1]
    on_test = similarity_bounds.query("scenes == 'test' and depth == 'all'")
    for ax, metric in zip(axes[0], ("psnr", "ssim", "rmse"), strict=True):
        plot_cases(ax, on_test, metric)
        if ax is not axes[0, 0]:
            ax.set_yticklabels([])
    axes[0, 0].legend(loc="upper left")
    plot_parts(of_parts, similarity_parts)
    # Held-out train scenes, rendered from picked layers and from all there are.
    for method, group in similarity_bounds.query("scenes != 'test'").groupby("method"):
        style = {"markersize": 6, **named_style(method)}
        of_layers.plot("layers", "psnr", "o-", data=group, **style)
    of_layers.set(ylabel=name_of("psnr"), xlabel="layers rendered")
    of_layers.margins(x=0.3)
    plot_blotches(of_air, air_texture.query("quantity == 'air_blotches'"))
    return figure


def plot_parts(ax, parts):
    """Mean square error taken apart, stacked; what is in common is left out."""
    parts = parts.query("part != 'speckle in common'")
    wide = parts.pivot_table(index="method", columns="part", values="mean_square", sort=False)
    methods = [name_of(method) for method in wide.index]
    left = np.zeros(len(wide))
    for name, colour in zip(wide, PART_COLOURS, strict=True):
        ax.barh(methods, wide[name], left=left, color=colour, label=name, height=0.5)
        left = left + wide[name].to_numpy()
    ax.set_ylim(-0.5, len(wide) + 1.5)  # room for the legend
    ax.set_xlabel("mean square error [grey levels squared]")
    ax.legend(loc="upper right")


def plot_blotches(ax, rows):
    """Texture above the surface, mean and range over scenes."""
    for row in rows.itertuples():
        colour = COLOURS[row.method]
        ax.plot([row.method] * 2, [row.min, row.max], color=colour)
        ax.plot(row.method, row.mean, "o", color=colour, markersize=6)
    ax.set_xticks(range(len(rows)), [name_of(method) for method in rows["method"]])
    ax.set_ylabel("blotches in the air [grey levels]")


def plot_cases(ax, rows, metric):
    """Similarity of both methods as rendered and without single faults, and its bounds."""
    cases = rows.query("method != 'bound'")["case"].unique()
    for method in METHODS:
        values = rows.query("method == @method").set_index("case")[metric].reindex(cases)
        ax.plot(values, range(len(cases)), "o", markersize=6, **named_style(method))
    bounds = rows.query("method == 'bound'").set_index("case")[metric]
    for dashes, (name, bound) in zip(("-", ":"), bounds.items(), strict=True):
        ax.axvline(bound, color="0.4", linestyle=dashes, linewidth=1, label=name)
    ax.set_yticks(range(len(cases)), cases)
    ax.set_ylim(len(cases) - 0.5, -2)  # room for a legend
    ax.set_xlabel(name_of(metric))


def worth(two_sample, drawn_scenes):
    """How often classifiers know drawn scenes from observed ones by depth, how they differ."""
    figure, axes = new_figure(2, 3, width=10, height=5.5)
    of_decisions, *of_numbers = axes.flat
    plot_decisions(of_decisions, two_sample)
    for ax, (quantity, labels) in zip(of_numbers, SCENE_NUMBERS.items(), strict=True):
        of_quantity = drawn_scenes[drawn_scenes["quantity"] == quantity]
        for name, rows in of_quantity.groupby("scenes", sort=False):
            style = {"color": COLOURS[name], "alpha": 0.2, "linewidth": 0}
            ax.fill_between("at", "low", "high", data=rows, **style)
            ax.plot("at", "mean", ".-", data=rows, markersize=6, **named_style(name))
        ax.set(**labels)
    of_numbers[0].legend(fontsize=7)
    return figure


def plot_decisions(ax, two_sample):
    """How often classifiers are right, by depth and, in the legend, in all."""
    for (name, classifier), rows in two_sample.groupby(["scenes", "classifier"], sort=False):
        scenes = "other half" if name == "observed" else name_of(name)
        whole = rows["accuracy"].iloc[0]
        marks = "o-" if classifier == "network" else "o:"
        style = {"color": COLOURS[name], "label": f"{scenes}, {classifier}: {whole:.2f}"}
        ax.plot("first_row", "accuracy", marks, data=rows.iloc[1:], **style)
    ax.axhline(0.5, color="0.5", linewidth=0.8)
    ax.set(xlabel="first range bin of the patch", ylabel="share of right decisions")
    ax.set(ylim=(0.4, 1.4), yticks=np.arange(4, 11, 2) / 10)
    ax.legend(loc="upper left")
