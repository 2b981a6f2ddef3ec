"""Layer masks to 8-bit echograms with a trained generator."""

import torch

from snowsim.cgan import pix2pix
from snowsim.cgan.brightness import expected_levels
from snowsim.cgan.inputs import conditions, place_map, slabs_of
from snowsim.cgan.train import networks_of
from snowsim.patches import from_signed
from snowsim.training import arithmetic, load_weights


def render(generator, scene, settings, *, levels=None, rng):
    """Echogram of the layers of a `Scene`, uint8, (range_bin, range_line), of any size.

    The whole is rendered at once, by `pix2pix` at the size of its crops. It does not depend on
    which others are rendered, in what order or by how many processes.

    Parameters
    ----------
    generator : UNetGenerator or Pix2PixGenerator
    scene : Scene
        ValueError if its mask holds no layer.
    settings : Settings
        Those it was trained with. Dropout stays on, as in pix2pix, drawn from `rng` as all noise
        is. FloatingPointError if a pixel is not finite.
    levels : Levels, optional
        How bright layers and snow are; by default as in the scene's image, or 1. Given, the
        brightest pixel of a render is white, as that of an observed image is.
    rng : numpy.random.Generator
    """
    mask = scene.mask()
    if not mask.any():
        msg = f"scene {scene.name}: mask without layers, "
        msg += f"expected at least one annotated pixel in {mask.shape}"
        raise ValueError(msg)
    generator.eval()
    if settings.method == "pix2pix":
        image = pix2pix.render_image(generator, scene, settings, rng=rng)
    else:
        image = _render_image(generator, scene, settings, levels, rng)
    if not torch.isfinite(image).all():
        msg = "generator renders values that are not finite: its training diverged"
        raise FloatingPointError(msg)
    return from_signed(image.clamp(-1, 1)[None, None])[0]


def render_as_expected(generator, scene, settings, flight, *, fade_spread, rng):
    """`render` of a scene as bright as its powers, or the statistics of a flight, tell.

    `fade_spread` is that of the scenes trained on. `pix2pix` knows no brightness.
    """
    levels = None
    if settings.method == "depth":
        levels = expected_levels(scene, flight, fade_spread=fade_spread, rng=rng)
    return render(generator, scene, settings, levels=levels, rng=rng)


def _render_image(generator, scene, settings, levels, rng):
    """Image with its grain, (range_bin, range_line); where levels tell, with contrast and fades."""
    places = place_map(scene, scene.layer_bins, scene.n_range_bins, levels)[None]
    inputs = conditions(places)
    contrast = 1.0 if levels is None else levels.contrast
    device = next(generator.parameters()).device
    noise = generator.draw_noise(slabs_of(places), dropout=settings.dropout, rng=rng)
    with torch.inference_mode(), arithmetic(device, settings.precision):
        image = generator(inputs.to(device), noise) + contrast * generator.grain(noise)
    image = image[0, 0]
    if levels is None:
        return image
    image = image + torch.as_tensor(contrast * levels.fades / 127.5).to(image)
    # The maximum of an observed image is white: how much is left above the rest is chance.
    return (image + 1) * (2 / (image.max() + 1)) - 1


def trained_generator(weights, settings, *, device="cpu"):
    """Generator for `render`, of weights (dict of arrays) and the `Settings` of their training."""
    generator, _ = networks_of(settings)
    load_weights(generator, weights, "generator")
    return generator.to(device=device, memory_format=torch.channels_last).eval()
