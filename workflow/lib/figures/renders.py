"""The cGAN's training, and single scenes: what a picker annotates, synthetic layers and both renders of them."""

from itertools import islice

import numpy as np

from lib.figures.style import BLACK, COLOURS, name_of, new_figure, note_source, plot_echogram, plot_layers, plot_picks

N_STEPS_SHOWN = 4
N_SCENES_SHOWN = 3
RUNNING_STEPS = 50
RICH_LAYERS = 6  # interfaces: scenes of few layers have little to annotate


def cgan_losses(losses, validation):
    """Losses of every step as running means, and similarity on the scenes set aside, the best checkpoint marked."""
    figure, axes = new_figure(1, 3, width=9)
    for column in (name for name in losses.columns if name != "step"):
        smooth = losses[column].rolling(RUNNING_STEPS, min_periods=1).mean()
        axes[0, 0].semilogy(losses["step"], smooth, linewidth=1, label=name_of(column))
    axes[0, 0].set(xlabel="step", ylabel="loss")
    axes[0, 0].legend(fontsize=7)
    best = validation.loc[validation["fitness"].idxmax()]
    for ax, metric in zip(axes[0, 1:], ("psnr", "ssim"), strict=True):
        ax.plot(validation["step"], validation[metric], "o-", color=COLOURS["cgan"], markersize=3)
        ax.plot(best["step"], best[metric], "o", color=BLACK, markersize=6, markerfacecolor="none")
        ax.set(xlabel="step", ylabel=name_of(metric))
    return figure


def cgan_samples(samples):
    """Layers, the observed scene and its renders after more and more steps, a row a scene."""
    sheets = {}
    for sample in samples:
        sheets.setdefault(sample.name, []).append(sample)
    steps = [sample.notes["step"] for sample in next(iter(sheets.values()))[1:]]
    shown = sorted({int(n) for n in np.rint(np.linspace(0, len(steps) - 1, N_STEPS_SHOWN))})
    figure, axes = new_figure(len(sheets), 2 + len(shown), width=9, height=1.8 * len(sheets), sharey="row")
    for row, (name, (observed, *rendered)) in zip(axes, sheets.items(), strict=True):
        plot_layers(row[0], observed.layer_bins, observed.n_range_bins, title=f"{name}: layers")
        plot_echogram(row[1], observed.image, title="observed")
        for ax, number in zip(row[2:], shown, strict=True):
            plot_echogram(ax, rendered[number].image, title=f"step {steps[number]}")
    return figure


def annotation(train, source):
    """A train scene, its annotation, and every layer there is: of rich scenes the one in the middle by share found."""
    shares = [annotated_share(scene) for scene in train]
    rich = [i for i, scene in enumerate(train) if complete_layers(scene).shape[0] > RICH_LAYERS] or range(len(train))
    ranked = sorted(rich, key=lambda i: (shares[i], i))
    middle = ranked[len(ranked) // 2]
    scene = train[middle]
    panels = {"echogram": None, "annotation": scene.layer_bins}
    if scene.complete_layer_bins is not None:
        title = f"semi-automatic annotation, {100 * shares[middle]:.0f} %"
        panels = {"echogram": None, title: scene.layer_bins, "corrected annotation": scene.complete_layer_bins}
    figure, axes = new_figure(1, len(panels), width=2.5 * len(panels), height=3.4, sharey=True)
    for ax, (title, layer_bins) in zip(axes[0], panels.items(), strict=True):
        plot_echogram(ax, scene.image, title)
        if layer_bins is not None:
            plot_picks(ax, layer_bins)
    axes[0, 0].set_ylabel("range bin")
    note_source(figure, f"{source}, train scene {scene.name}")
    return figure


def complete_layers(scene):
    """Every layer of a scene; those annotated where no more are known."""
    return scene.layer_bins if scene.complete_layer_bins is None else scene.complete_layer_bins


def annotated_share(scene):
    """Share of a scene's layer pixels below the surface that are annotated; 1 where there are none."""
    whole = np.isfinite(complete_layers(scene)[1:]).sum()
    return np.isfinite(scene.layer_bins[1:]).sum() / whole if whole else 1.0


def synthetic(labels, phy, cgan, n_labels, source):
    """Layers of few, some and many of the first label sets, and both renders of them."""
    order = np.argsort([scene.layer_bins.shape[0] for scene in islice(labels, n_labels)], kind="stable")
    chosen = np.unique(np.rint(np.linspace(0, order.size - 1, N_SCENES_SHOWN)).astype(int))
    figure, axes = new_figure(chosen.size, 3, width=6.5, height=2.5 * chosen.size)
    for row, i in zip(axes, order[chosen], strict=True):
        scene = labels[int(i)]
        plot_layers(row[0], scene.layer_bins, scene.n_range_bins, f"{scene.layer_bins.shape[0] - 1} layers drawn")
        plot_echogram(row[1], phy[int(i)].image, "PHY")
        plot_echogram(row[2], cgan[int(i)].image, "cGAN")
        row[0].set_ylabel("range bin")
    note_source(figure, f"synthetic layers from the statistics of: {source}")
    return figure
