"""Scenes rendered by PHY with the settings of the configuration."""

from snowsim.labels import Dress, dress
from snowsim.phy import render_scene


def render_by_phy(scene, flight, phy, *, rng, added_power=None):
    """The scene with its image; one without echoes of its own has the flight's mean powers."""
    choices, options = Dress.split(phy)
    echoes = scene.echoes
    if echoes is None:
        echoes = dress(scene.layer_bins, flight, choices, rng=rng)
    return render_scene(scene, echoes=echoes, rng=rng, added_power=added_power, **options)
