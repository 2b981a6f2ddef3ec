"""The cGAN's training, and renders of observed and of synthetic layers."""

import numpy as np

from evaluation.lib.figures.style import (
    BLACK,
    METHODS,
    RED,
    evenly_spaced,
    name_of,
    new_figure,
)
from snowsim.echogram import MINIMUM_ROWS

RUNNING_STEPS = 50  # of means of losses
N_SCENES_SHOWN = 3  # observed ones, and as many synthetic ones


def cgan_losses(losses, validation):
    """Running means of losses, and how near held-out scenes are, the chosen weights marked."""
    figure, axes = new_figure(1, 3, width=9)
    of_losses, *of_scores = axes[0]
    smooth = losses.set_index("step").rolling(RUNNING_STEPS, min_periods=1).mean()
    smooth.rename(columns=name_of).plot(ax=of_losses, logy=True, style=["-", "--", "-.", ":"])
    of_losses.set(ylabel="loss", title=f"running means of {RUNNING_STEPS} steps")
    best = validation.loc[validation["fitness"].idxmax()]
    for ax, score in zip(of_scores, ("distance", "ssim"), strict=True):
        ax.plot(validation["step"], validation[score], "o-", color=RED)
        ax.plot(best["step"], best[score], "o", color=BLACK, markersize=8, fillstyle="none")
        ax.set(xlabel="step", ylabel=name_of(score), title="renders of held-out scenes")
    return figure


def sample(test, drawn, images, scale):
    """Observed and synthetic layers with their renders, a column a scene, the uppermost rows.

    `test` and `drawn` map methods to scenes, `test` also `observed`. Test scenes are those where
    the cGAN's SSIM, by the table `images`, is least, in the middle and most; beside them stand
    label sets of about as many layers.
    """
    observed = list(test["observed"])
    ssim = images[images["method"] == "cgan"].set_index("scene")["ssim"]
    chosen = evenly_spaced([ssim[scene.name] for scene in observed], N_SCENES_SHOWN)
    n_drawn = np.array([count_layers(scene) for scene in drawn["phy"]])
    size = {"width": 10, "height": 7, "sharex": True, "sharey": True}
    figure, axes = new_figure(2 + len(METHODS), 2 * chosen.size, **size)
    for number, place in enumerate(map(int, chosen)):
        above, *below = axes[:, number]
        scale.plot_image(above, observed[place].image[:MINIMUM_ROWS])
        above.set_title(observed[place].name)
        plot_scene(below, [test[method][place] for method in METHODS], scale)
        distance = np.abs(n_drawn - count_layers(observed[place]))
        # Each time the next one: scenes of as many layers then have different ones beside them.
        alike = int(np.argsort(distance, kind="stable")[number % n_drawn.size])
        above, *below = axes[:, chosen.size + number]
        above.set_axis_off()
        plot_scene(below, [drawn[method][alike] for method in METHODS], scale)
    above.set_title("synthetic layers, from the statistics of the flight", loc="right", y=0.4)
    for ax, what in zip(axes[:, 0], ("observed", "layers", *METHODS), strict=True):
        ax.set_ylabel(f"{name_of(what)}\ndepth [m]")
    for ax in axes[-1]:
        ax.set_xlabel("along track [km]")
    return figure


def plot_scene(axes, renders, scale):
    """Layers of a scene, and its renders below each other."""
    of_layers, *of_renders = axes
    scale.plot_layers(of_layers, renders[0].layer_bins, color=BLACK)
    of_layers.set_title(f"layers below the surface: {count_layers(renders[0])}")
    for ax, render in zip(of_renders, renders, strict=True):
        scale.plot_image(ax, render.image[:MINIMUM_ROWS])


def count_layers(scene):
    """How many layers below the surface are labelled somewhere."""
    is_labelled = np.isfinite(scene.layer_bins[1:]).any(axis=1)
    return int(is_labelled.sum())
