"""Scenes rendered by PHY with the recipe of the configuration."""

import dataclasses

from snowsim.labels import echoes_of_layers, echoes_of_layers_as_printed
from snowsim.phy import render_scene


def is_printed(phy):
    """Whether the configuration's section `phy` asks for the paper's recipe."""
    return phy["recipe"] == "paper"


def render_by_phy(scene, flight, phy, *, rng, added_power=0.0):
    """The scene with its image; one without echoes of its own has the flight's mean powers."""
    echoes = scene.echoes
    printed = is_printed(phy)
    if echoes is None and printed:
        echoes = echoes_of_layers_as_printed(scene.layer_bins, flight, rng=rng)
    elif echoes is None:
        echoes = echoes_of_layers(scene.layer_bins, flight)
    if phy["n_looks"] is not None:
        echoes = dataclasses.replace(echoes, n_looks=phy["n_looks"])
    return render_scene(scene, echoes=echoes, rng=rng, added_power=added_power, as_printed=printed)
