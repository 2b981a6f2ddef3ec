"""The cGAN's training, and single scenes: what a picker annotates, observed scenes beside drawn ones."""

from itertools import islice

import numpy as np

from lib.figures import style
from lib.figures.style import (
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
    """Losses of every step as running means, and similarity on the held-out scenes, the best checkpoint marked."""
    figure, axes = new_figure(1, 3, width=9)
    for column in (name for name in losses.columns if name != "step"):
        smooth = losses[column].rolling(style.RUNNING_STEPS, min_periods=1).mean()
        axes[0, 0].semilogy(losses["step"], smooth, linewidth=1, label=name_of(column))
    axes[0, 0].set(xlabel="step", ylabel="loss")
    axes[0, 0].legend(fontsize=7)
    best = validation.loc[validation["fitness"].idxmax()]
    for ax, metric in zip(axes[0, 1:], ("psnr", "ssim"), strict=True):
        ax.plot(
            validation["step"], validation[metric], "o-", color=style.COLOURS["cgan"], markersize=3
        )
        ax.plot(
            best["step"], best[metric], "o", color=style.BLACK, markersize=6, markerfacecolor="none"
        )
        ax.set(xlabel="step", ylabel=name_of(metric))
    return figure


def cgan_samples(samples):
    """Layers, the observed scene and its renders after more and more steps, a row a scene."""
    sheets = {}
    for sample in samples:
        sheets.setdefault(sample.name, []).append(sample)
    steps = [sample.notes["step"] for sample in next(iter(sheets.values()))[1:]]
    shown = evenly_spaced(steps, N_STEPS_SHOWN)
    figure, axes = new_figure(
        len(sheets), 2 + len(shown), width=9, height=1.8 * len(sheets), sharey="row"
    )
    for row, (name, (observed, *rendered)) in zip(axes, sheets.items(), strict=True):
        plot_layers(row[0], observed, f"{name}: layers")
        plot_echogram(row[1], observed.image, "observed")
        for ax, number in zip(row[2:], shown, strict=True):
            plot_echogram(ax, rendered[number].image, f"step {steps[number]}")
    return figure


def annotation(train, source):
    """A train scene, its annotation, and every layer there is: of rich scenes the one in the middle by share found."""
    shares = [annotated_share(scene) for scene in train]
    rich = [
        i for i, scene in enumerate(train) if complete_layers(scene).shape[0] > RICH_LAYERS
    ] or range(len(train))
    middle = sorted(rich, key=lambda i: (shares[i], i))[len(rich) // 2]
    scene = train[middle]
    panels = {"echogram": None, "annotation": scene.layer_bins}
    if scene.complete_layer_bins is not None:
        title = f"semi-automatic annotation, {100 * shares[middle]:.0f} %"
        panels = {
            "echogram": None,
            title: scene.layer_bins,
            "corrected annotation": scene.complete_layer_bins,
        }
    figure, axes = new_figure(1, len(panels), width=2.5 * len(panels), height=3.4, sharey=True)
    for ax, (title, layer_bins) in zip(axes[0], panels.items(), strict=True):
        plot_echogram(ax, scene.image, title)
        if layer_bins is not None:
            plot_picks(ax, layer_bins)
    axes[0, 0].set_ylabel("range bin")
    return note_source(figure, f"{source}, train scene {scene.name}")


def complete_layers(scene):
    """Every layer of a scene; those annotated where no more are known."""
    return scene.layer_bins if scene.complete_layer_bins is None else scene.complete_layer_bins


def annotated_share(scene):
    """Share of a scene's layer pixels below the surface that are annotated; 1 where there are none."""
    whole = np.isfinite(complete_layers(scene)[1:]).sum()
    return np.isfinite(scene.layer_bins[1:]).sum() / whole if whole else 1.0


def synthetic(test, phy, cgan, n_labels, source):
    """Observed scenes of few, some and many layers above drawn ones of as many, with their layers and both renders."""
    n_observed = [count_layers(scene) for scene in test]
    n_drawn = [count_layers(scene) for scene in islice(phy, n_labels)]
    with_layers = np.flatnonzero(n_observed) if any(n_observed) else np.arange(len(n_observed))
    chosen = with_layers[evenly_spaced(np.array(n_observed)[with_layers], N_SCENES_SHOWN)]
    left = np.array(n_drawn, dtype=float)  # NaN once shown
    figure, axes = new_figure(
        5, chosen.size, width=2.3 * chosen.size, height=8.5, sharex=True, sharey=True
    )
    for column, i in zip(axes.T, chosen, strict=True):
        alike = int(np.nanargmin(np.abs(left - n_observed[i]))) if np.isfinite(left).any() else 0
        left[alike] = np.nan
        observed, drawn = test[int(i)], phy[alike]
        plot_echogram(column[0], observed.image[:MINIMUM_ROWS], "observed")
        plot_layers(column[1], observed, f"its layers, {n_observed[i]} below the surface")
        plot_layers(column[2], drawn, f"drawn, {n_drawn[alike]} below the surface")
        plot_echogram(column[3], drawn.image[:MINIMUM_ROWS], "drawn, PHY")
        plot_echogram(column[4], cgan[alike].image[:MINIMUM_ROWS], "drawn, cGAN")
        column[0].set_ylim(MINIMUM_ROWS - 0.5, -0.5)
        for ax in column[:-1]:
            ax.set_xlabel("")
    for ax in axes[:, 0]:
        ax.set_ylabel("range bin")
    return note_source(figure, f"synthetic layers from the statistics of: {source}")


def count_layers(scene):
    """How many layers below the surface are labelled somewhere."""
    return int(np.isfinite(scene.layer_bins[1:]).any(axis=1).sum())
