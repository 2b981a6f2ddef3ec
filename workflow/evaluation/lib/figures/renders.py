"""The cGAN's training, and single scenes: annotated ones, and observed beside drawn ones."""

from itertools import islice

import numpy as np

from evaluation.lib.figures.style import (
    BLACK,
    COLOURS,
    RUNNING_STEPS,
    evenly_spaced,
    name_of,
    new_figure,
    note_source,
    plot_echogram,
    plot_layers,
    plot_picks,
)
from snowsim.echogram import MINIMUM_ROWS

N_STEPS_SHOWN = 4
N_SCENES_SHOWN = 4
RICH_LAYERS = 6  # interfaces: scenes of few layers have little to annotate


def cgan_losses(losses, validation):
    """Running means of losses, and similarity on held-out scenes, the best checkpoint marked."""
    figure, axes = new_figure(1, 3, width=9)
    of_losses, *of_metrics = axes[0]
    losses = losses.set_index("step")
    for column in losses:
        smooth = losses[column].rolling(RUNNING_STEPS, min_periods=1).mean()
        of_losses.semilogy(smooth, linewidth=1, label=name_of(column))
    of_losses.set(xlabel="step", ylabel="loss")
    of_losses.legend(fontsize=7)
    best = validation.loc[validation["fitness"].idxmax()]
    for ax, metric in zip(of_metrics, ("psnr", "ssim"), strict=True):
        ax.plot("step", metric, "o-", data=validation, color=COLOURS["cgan"])
        circle = {"markersize": 6, "markerfacecolor": "none"}
        ax.plot(best["step"], best[metric], "o", color=BLACK, **circle)
        ax.set(xlabel="step", ylabel=name_of(metric))
    return figure


def cgan_samples(samples):
    """Layers, the observed scene and its renders after more and more steps, a row a scene."""
    sheets = {}
    for sample in samples:
        sheets.setdefault(sample.name, []).append(sample)
    n_sheets = len(sheets)
    first = next(iter(sheets.values()))
    steps = [sample.notes["step"] for sample in first[1:]]
    shown = evenly_spaced(steps, N_STEPS_SHOWN)
    size = {"width": 9, "height": 1.8 * n_sheets}
    figure, axes = new_figure(n_sheets, 2 + len(shown), sharey="row", **size)
    for row, (name, (observed, *rendered)) in zip(axes, sheets.items(), strict=True):
        plot_layers(row[0], observed, f"{name}: layers")
        plot_echogram(row[1], observed.image, "observed")
        for ax, number in zip(row[2:], shown, strict=True):
            plot_echogram(ax, rendered[number].image, f"step {steps[number]}")
    return figure


def annotation(train, source):
    """A train scene, its annotation, and every layer there is.

    Of rich scenes the one in the middle by the share that is annotated.
    """
    shares = [annotated_share(scene) for scene in train]
    numbers = range(len(train))
    rich = [i for i in numbers if complete_layers(train[i]).shape[0] > RICH_LAYERS]
    ranked = sorted(rich or numbers, key=lambda i: (shares[i], i))
    middle = ranked[len(ranked) // 2]
    scene = train[middle]
    panels = {"annotation": scene.layer_bins}
    if scene.complete_layer_bins is not None:
        title = f"semi-automatic annotation, {100 * shares[middle]:.0f} %"
        panels = {title: scene.layer_bins, "corrected annotation": scene.complete_layer_bins}
    n_panels = 1 + len(panels)
    figure, axes = new_figure(1, n_panels, width=2.5 * n_panels, height=3.4, sharey=True)
    bare, *annotated = axes[0]
    plot_echogram(bare, scene.image, "echogram")
    bare.set_ylabel("range bin")
    for ax, (title, layer_bins) in zip(annotated, panels.items(), strict=True):
        plot_echogram(ax, scene.image, title)
        plot_picks(ax, layer_bins)
    return note_source(figure, f"{source}, train scene {scene.name}")


def complete_layers(scene):
    """Every layer of a scene; those annotated where no more are known."""
    return scene.layer_bins if scene.complete_layer_bins is None else scene.complete_layer_bins


def annotated_share(scene):
    """Share of a scene's layer pixels below the surface that are annotated; 1 without any."""
    whole = np.isfinite(complete_layers(scene)[1:]).sum()
    annotated = np.isfinite(scene.layer_bins[1:]).sum()
    return annotated / whole if whole else 1.0


def synthetic(test, phy, cgan, n_labels, source):
    """Observed scenes of few to many layers above drawn ones of as many, with both renders."""
    n_observed = np.array([count_layers(scene) for scene in test])
    n_drawn = [count_layers(scene) for scene in islice(phy, n_labels)]
    with_layers = np.flatnonzero(n_observed) if n_observed.any() else np.arange(len(n_observed))
    chosen = with_layers[evenly_spaced(n_observed[with_layers], N_SCENES_SHOWN)]
    left = np.array(n_drawn, dtype=float)  # NaN once shown
    size = {"width": 2.3 * chosen.size, "height": 8.5}
    figure, axes = new_figure(5, chosen.size, sharex=True, sharey=True, **size)
    for column, i in zip(axes.T, chosen, strict=True):
        distance = np.abs(left - n_observed[i])
        alike = int(np.nanargmin(distance)) if np.isfinite(left).any() else 0
        left[alike] = np.nan
        plot_observed(column[:2], test[int(i)])
        plot_drawn(column[2:], phy[alike], cgan[alike])
        column[0].set_ylim(MINIMUM_ROWS - 0.5, -0.5)
        for ax in column[:-1]:
            ax.set_xlabel("")
    for ax in axes[:, 0]:
        ax.set_ylabel("range bin")
    return note_source(figure, f"synthetic layers from the statistics of: {source}")


def plot_observed(axes, scene):
    """An observed scene and its layers."""
    plot_echogram(axes[0], scene.image[:MINIMUM_ROWS], "observed")
    plot_layers(axes[1], scene, f"its layers, {count_layers(scene)} below the surface")


def plot_drawn(axes, by_phy, by_cgan):
    """A drawn scene: its layers, and both renders of them."""
    plot_layers(axes[0], by_phy, f"drawn, {count_layers(by_phy)} below the surface")
    plot_echogram(axes[1], by_phy.image[:MINIMUM_ROWS], "drawn, PHY")
    plot_echogram(axes[2], by_cgan.image[:MINIMUM_ROWS], "drawn, cGAN")


def count_layers(scene):
    """How many layers below the surface are labelled somewhere."""
    is_labelled = np.isfinite(scene.layer_bins[1:]).any(axis=1)
    return int(is_labelled.sum())
