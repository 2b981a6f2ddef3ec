"""Scenes rendered by PHY with the settings of the configuration."""

import dataclasses

from snowsim.labels import dress, dress_as_printed
from snowsim.phy import render_scene

OPTIONS = ("tolerance_db", "speckle", "normalise", "align")


def render_by_phy(scene, flight, phy, *, rng, added_power=None):
    """The scene with its image; one without echoes of its own has the flight's mean powers."""
    echoes = scene.echoes
    if echoes is None and phy["width"] == "paper":
        echoes = dress_as_printed(scene.layer_bins, flight, rng=rng)
    elif echoes is None:
        echoes = dress(scene.layer_bins, flight)
    if phy["n_looks"] is not None:
        echoes = dataclasses.replace(echoes, n_looks=phy["n_looks"])
    options = {name: phy[name] for name in OPTIONS}
    return render_scene(scene, echoes=echoes, rng=rng, added_power=added_power, **options)
