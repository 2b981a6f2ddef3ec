"""Similarity of renders to observed scenes, what bounds it, where layers lie in renders, and their texture."""

import numpy as np

from lib.figures import style
from lib.figures.style import COLOURS, METHODS, name_of, new_figure, plot_echogram, plot_layers
from snowsim.echogram import SURFACE_ROW

N_SCENES_SHOWN = 3
PART_COLOURS = (
    style.BLACK,
    style.BLUE,
    style.SKY,
    style.ORANGE,
    style.PINK,
)  # of the mean square error
# Numbers of drawn and observed scenes: along what, what, and of what axes.
SCENE_NUMBERS = {
    "contrast of layers": (
        "layer below the surface",
        "contrast of labelled layers [dB]",
        ("linear", "linear"),
    ),
    "structure function, slabs": (
        "lag [range lines]",
        "structure function of slabs [bins²]",
        ("log", "log"),
    ),
    "structure function, layers": (
        "lag [range lines]",
        "structure function of layers [bins²]",
        ("log", "log"),
    ),
    "autocorrelation, range_line": (
        "lag [range lines]",
        "autocorrelation along track",
        ("log", "linear"),
    ),
    "autocorrelation, range_bin": (
        "lag [range bins]",
        "autocorrelation down range",
        ("log", "linear"),
    ),
}


def similarity_boxplots(images):
    """The three metrics of every method as box plots."""
    figure, axes = new_figure(1, 3, width=7)
    methods = sorted(images["method"].unique())
    for ax, metric in zip(axes.flat, ("ssim", "psnr", "rmse"), strict=True):
        values = [images.loc[images["method"] == method, metric] for method in methods]
        labels, fliers = [name_of(method) for method in methods], {"marker": ".", "markersize": 4}
        boxes = ax.boxplot(
            [v[np.isfinite(v)] for v in values], tick_labels=labels, widths=0.5, flierprops=fliers
        )
        for box, median, method in zip(boxes["boxes"], boxes["medians"], methods, strict=True):
            box.set_color(COLOURS[method])
            median.set(color=COLOURS[method], linewidth=2)
        ax.set_ylabel(f"{name_of(metric)}{' [grey levels]' if metric == 'rmse' else ''}")
    return figure


def ssim_depth(ssim_depth):
    """SSIM against range bin, smoothed, the surface marked."""
    figure, axes = new_figure()
    ax = axes[0, 0]
    for method, rows in ssim_depth.groupby("method"):
        ax.plot(rows["range_bin"], rows["ssim"], color=COLOURS[method], alpha=0.25, linewidth=0.7)
        ax.plot(
            rows["range_bin"], rows["ssim_smooth"], color=COLOURS[method], label=name_of(method)
        )
    ax.axvline(SURFACE_ROW, color="0.5", linestyle=":", linewidth=1)
    ax.annotate("snow surface", (SURFACE_ROW, 0.98), xycoords=("data", "axes fraction"), fontsize=7, va="top",
                xytext=(4, 0), textcoords="offset points")  # fmt: skip
    ax.set(xlabel="range bin", ylabel="SSIM")
    ax.legend()
    return figure


def sample(observed, cgan, phy, images):
    """Observed scene, its layers, and both renders of them, for scenes at the quartiles of cGAN's SSIM."""
    ranked = images[images["method"] == "cgan"].sort_values(["ssim", "scene"])["scene"].to_list()
    names = [
        ranked[round(rank)] for rank in np.linspace(0, len(ranked) - 1, N_SCENES_SHOWN + 2)[1:-1]
    ]
    figure, axes = new_figure(len(names), 4, width=8, height=2.6 * len(names))
    for column, scenes, title in ((0, observed, "observed"), (2, cgan, "cGAN"), (3, phy, "PHY")):
        chosen = {scene.name: scene for scene in scenes if scene.name in names}
        for row, name in zip(axes, names, strict=True):
            plot_echogram(row[column], chosen[name].image, title)
            if scenes is observed:
                plot_layers(row[1], chosen[name], f"layers of {name}")
                row[0].set_ylabel("range bin")
    return figure


def render_positions(render_positions):
    """Distance from layers to the peak near them by slope and curvature: means over scenes, two standard errors."""
    figure, axes = new_figure(1, 2, width=8, height=3.2, sharey=True)
    units = {"slope": "range bins per range line", "curvature": "range bins per range line²"}
    for ax, (against, unit) in zip(axes[0], units.items(), strict=True):
        chosen = render_positions[render_positions["against"] == against]
        for k, (method, rows) in enumerate(chosen.groupby("method")):
            groups = rows.groupby("shape_class")["mean_abs_error_bins"]
            error = 2 * groups.std() / np.sqrt(groups.count())
            style = {
                "fmt": "o-",
                "color": COLOURS[method],
                "markersize": 4,
                "label": name_of(method),
            }
            ax.errorbar(groups.mean().index + 0.08 * (k - 1), groups.mean(), error, **style)
        edges = chosen.drop_duplicates("shape_class").sort_values("shape_class")
        labels = [
            f"below {high:.2g}"
            if low == 0
            else f"above {low:.2g}"
            if np.isinf(high)
            else f"{low:.2g} to {high:.2g}"
            for low, high in zip(edges["shape_low"], edges["shape_high"], strict=True)
        ]
        ax.set_xticks(range(len(labels)), labels, fontsize=7)
        ax.set(xlabel=f"{against} [{unit}]", ylim=(0, None))
    axes[0, 0].set_ylabel("distance to the peak [range bins]")
    axes[0, 0].legend(loc="lower left")
    return figure


def similarity_bounds(similarity_bounds, similarity_parts, air_texture):
    """Bounds of similarity and what keeps renders from them, annotation, and texture in the air."""
    bounds, air = similarity_bounds, air_texture[air_texture["quantity"] == "air_blotches"]
    figure, axes = new_figure(2, 3, width=10, height=5.5)
    for ax, metric in zip(axes[0], ("psnr", "ssim", "rmse"), strict=True):
        plot_cases(ax, bounds[(bounds["scenes"] == "test") & (bounds["depth"] == "all")], metric)
        if ax is not axes[0, 0]:
            ax.set_yticklabels([])
    axes[0, 0].legend(fontsize=6, loc="upper left")
    # Mean square error taken apart, stacked; what is in common is left out.
    ax = axes[1, 0]
    wide = similarity_parts.pivot_table(
        index="method", columns="part", values="mean_square", sort=False
    )
    methods, left = [name_of(method) for method in wide.index], np.zeros(len(wide))
    for name, colour in zip(
        [name for name in wide.columns if name != "speckle in common"], PART_COLOURS, strict=True
    ):
        ax.barh(methods, wide[name], left=left, color=colour, label=name, height=0.5)
        left = left + wide[name].to_numpy()
    ax.set_ylim(-0.5, len(wide) + 1.5)  # room for the legend
    ax.set_xlabel("mean square error [grey levels squared]")
    ax.legend(fontsize=6, loc="upper right")
    # Held-out train scenes, rendered from picked layers and from all there are.
    for method, group in bounds[bounds["scenes"] != "test"].groupby("method"):
        axes[1, 1].plot(
            group["layers"], group["psnr"], "o-", color=COLOURS[method], label=name_of(method)
        )
    axes[1, 1].set(ylabel=name_of("psnr"), xlabel="layers rendered")
    axes[1, 1].margins(x=0.3)
    for row in air.itertuples():
        colour = COLOURS[row.method]
        axes[1, 2].plot([row.method] * 2, [row.min, row.max], color=colour)
        axes[1, 2].plot(row.method, row.mean, "o", color=colour)
    axes[1, 2].set_xticks(range(len(air)), [name_of(method) for method in air["method"]])
    axes[1, 2].set_ylabel("blotches in the air [grey levels]")
    return figure


def plot_cases(ax, rows, metric):
    """Similarity of both methods as rendered and without single faults, and its bounds."""
    cases = list(dict.fromkeys(rows.loc[rows["method"] != "bound", "case"]))
    for method in METHODS:
        values = rows[rows["method"] == method].set_index("case")[metric].reindex(cases)
        ax.plot(values, range(len(cases)), "o", color=COLOURS[method], label=name_of(method))
    for dashes, bound in zip(("-", ":"), rows[rows["method"] == "bound"].itertuples(), strict=True):
        ax.axvline(
            getattr(bound, metric), color="0.4", linestyle=dashes, linewidth=1, label=bound.case
        )
    ax.set_yticks(range(len(cases)), cases)
    ax.set_ylim(len(cases) - 0.5, -2)  # room for a legend
    ax.set_xlabel(name_of(metric))


def worth(two_sample, drawn_scenes):
    """How often drawn scenes are distinguished from observed ones, by depth, and by what they differ."""
    figure, axes = new_figure(2, 3, width=10, height=5.5)
    for (name, classifier), rows in two_sample.groupby(["scenes", "classifier"], sort=False):
        whole, by_depth = rows.iloc[0], rows.iloc[1:]
        label = f"{'other half' if name == 'observed' else name_of(name)}, {classifier}: {whole['accuracy']:.2f}"
        dashes = "o-" if classifier == "network" else "o:"
        style = {"color": COLOURS[name], "markersize": 3, "label": label}
        axes[0, 0].plot(by_depth["first_row"], by_depth["accuracy"], dashes, **style)
    axes[0, 0].axhline(0.5, color="0.5", linewidth=0.8)
    axes[0, 0].set(xlabel="first range bin of the patch", ylabel="share of right decisions")
    axes[0, 0].set(ylim=(0.4, 1.4), yticks=np.arange(4, 11, 2) / 10)
    axes[0, 0].legend(fontsize=6, loc="upper left")
    for ax, (quantity, (at, label, scales)) in zip(
        axes.flat[1:], SCENE_NUMBERS.items(), strict=True
    ):
        for name, rows in drawn_scenes[drawn_scenes["quantity"] == quantity].groupby(
            "scenes", sort=False
        ):
            ax.fill_between(
                rows["at"], rows["low"], rows["high"], color=COLOURS[name], alpha=0.2, linewidth=0
            )
            ax.plot(rows["at"], rows["mean"], ".-", color=COLOURS[name], label=name_of(name))
        ax.set(xlabel=at, ylabel=label, xscale=scales[0], yscale=scales[1])
    axes[0, 1].legend(fontsize=7)
    return figure
