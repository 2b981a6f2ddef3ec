"""Renders of observed and of synthetic layers."""

from evaluation.lib.figures.style import (
    BLACK,
    METHODS,
    evenly_spaced,
    name_of,
    new_figure,
)
from snowsim.echogram import MINIMUM_ROWS

N_SCENES_SHOWN = 3  # observed ones, and as many synthetic ones


def sample(test, drawn, scale):
    """Observed and synthetic layers with their renders, a column a scene, the uppermost rows.

    `test` and `drawn` map methods to scenes, `test` also `observed`: those of some, more and most
    layers are shown.
    """
    columns = []
    for scenes in (test, drawn):
        n_layers = [len(scene.layer_bins) for scene in scenes["phy"]]
        places = evenly_spaced(n_layers, N_SCENES_SHOWN + 1)[-N_SCENES_SHOWN:]
        columns += [{name: of[place] for name, of in scenes.items()} for place in places]
    size = {"width": 10, "height": 7, "sharex": True, "sharey": True}
    figure, axes = new_figure(2 + len(METHODS), len(columns), **size)
    for (above, of_layers, *of_renders), scenes in zip(axes.T, columns, strict=True):
        scale.plot_layers(of_layers, scenes["phy"].layer_bins, color=BLACK)
        of_layers.set_title(f"layers: {len(scenes['phy'].layer_bins) - 1}")
        for ax, method in zip(of_renders, METHODS, strict=True):
            scale.plot_image(ax, scenes[method].image[:MINIMUM_ROWS])
        if "observed" in scenes:
            scale.plot_image(above, scenes["observed"].image[:MINIMUM_ROWS])
            above.set_title(scenes["observed"].name)
        else:
            above.set_axis_off()
        of_renders[-1].set_xlabel("along track [km]")
    above.set_title("synthetic layers, from the statistics of the flight", loc="right", y=0.4)
    for ax, what in zip(axes[:, 0], ("observed", "layers", *METHODS), strict=True):
        ax.set_ylabel(f"{name_of(what)}\ndepth [m]")
    return figure
