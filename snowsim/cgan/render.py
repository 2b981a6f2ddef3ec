"""Layer masks to 8-bit echograms with a trained generator."""

import torch

from snowsim.cgan.train import RECIPES, networks_of
from snowsim.patches import from_signed
from snowsim.training import load_weights


def render(generator, scene, settings, *, rng):
    """Echogram of the layers of a `Scene`, uint8, (range_bin, range_line), of any size.

    The whole is rendered at once, by `pix2pix` at the size of its crops. It does not depend on
    which others are rendered, in what order or by how many processes.

    Parameters
    ----------
    generator : torch.nn.Module
        Of `trained_generator`.
    scene : Scene
        Its echoes tell how bright layers and snow are; `pix2pix` needs none. ValueError if its mask
        holds no layer, or if it lacks them.
    settings : Settings
        Those it was trained with. FloatingPointError if a pixel is not finite.
    rng : numpy.random.Generator
        All noise is drawn from it.
    """
    mask = scene.mask()
    if not mask.any():
        msg = f"scene {scene.name}: mask without layers, "
        msg += f"expected at least one annotated pixel in {mask.shape}"
        raise ValueError(msg)
    generator.eval()
    image = RECIPES[settings.method].render_image(generator, scene, settings, rng=rng)
    if not torch.isfinite(image).all():
        msg = "generator renders values that are not finite: its training diverged"
        raise FloatingPointError(msg)
    return from_signed(image.clamp(-1, 1)[None, None])[0]


def trained_generator(weights, settings, *, device="cpu"):
    """Generator for `render`, of weights (dict of arrays) and the `Settings` of their training."""
    generator, _ = networks_of(settings)
    generator = load_weights(generator, weights, "generator")
    return generator.to(device=device, memory_format=torch.channels_last).eval()
