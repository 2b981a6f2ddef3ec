"""Scenes rendered by PHY with the recipe of the configuration."""

from snowsim.labels import Dress, dress
from snowsim.phy import render_scene

# Section III: variances of U(10, 15), measured as a 1/e width; nothing but layers.
PRINTED = {
    "width": "paper",
    "width_bounds": (10, 15),
    "speckle_correlation": "none",
    "background": "none",
}


def dress_of(phy):
    """`Dress` of the recipe that the configuration's section `phy` names."""
    return Dress(n_looks=phy["n_looks"], **(PRINTED if is_printed(phy) else {}))


def is_printed(phy):
    """Whether the configuration's section `phy` asks for the paper's recipe."""
    return phy["recipe"] == "paper"


def render_by_phy(scene, flight, phy, *, rng, added_power=0.0):
    """The scene with its image; one without echoes of its own has the flight's mean powers."""
    echoes = scene.echoes
    if echoes is None:
        echoes = dress(scene.layer_bins, flight, dress_of(phy), rng=rng)
    printed = is_printed(phy)
    return render_scene(scene, echoes=echoes, rng=rng, added_power=added_power, as_printed=printed)
