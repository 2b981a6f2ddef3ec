"""Scenes rendered by a trained generator."""

from lib.brightness import expected_levels
from snowsim.cgan import Settings, render, trained_generator
from snowsim.io.models import read_model


def scene_renderer(path_to_generator, flight, device):
    """A trained generator as a function of scene and random stream; and what it was trained on."""
    weights, metadata = read_model(path_to_generator, {"kind": "cgan generator"})
    settings = Settings(**metadata["settings"])
    network = trained_generator(weights, settings, device=device)
    spread = metadata["fade_spread"]

    def by_network(scene, rng):
        levels = None
        if settings.method == "depth":
            levels = expected_levels(scene, flight, fade_spread=spread, rng=rng)
        return render(network, scene, settings, levels=levels, rng=rng)

    return by_network, metadata["scope"]
