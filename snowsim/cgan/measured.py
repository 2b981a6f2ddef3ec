"""The recipe `measured`: a generator that is given the levels of layers and of snow.

It makes an image without speckle, to which grain is added, with the moments of what it lacks.
"""

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from snowsim.cgan.grain import Grain
from snowsim.cgan.inputs import (
    N_CHANNELS,
    expected_image,
    inputs_of,
    is_snow,
    known_map,
    snow_level,
)
from snowsim.cgan.networks import Norm, PatchDiscriminator, ResizeConvolution, UNet, update
from snowsim.patches import check_trainable, draw_patches, to_signed
from snowsim.training import arithmetic


class Generator(nn.Module):
    """U-Net from `inputs_of` to images, (patch, 1, range_bin, range_line) in [-1, 1].

    Images may have any size: inputs, layers first, are continued to a multiple of ``2**depth``,
    downwards without layers and sideways with the last range line, and the output cut back.
    Features are normalised over the channels of each pixel: an image depends on what is within ``3
    * 2**depth`` pixels alone. Inputs have a random level for each slab, and images are doubled
    before they are convolved (Odena, Dumoulin & Olah 2016, Distill): equal inputs leave no lattice.
    Its `grain` is to be added to its images.
    """

    def __init__(self, width, depth, n_inputs=N_CHANNELS):
        super().__init__()
        self.multiple = 2**depth
        n_inputs += 1  # the level of its slab
        n_last = max(width // 2, 1)
        layers = {"norm": Norm, "doubling": ResizeConvolution}
        self.unet = UNet(n_inputs, n_last, width, depth, **layers)
        self.last = nn.Conv2d(n_last + n_inputs, 1, 3, padding=1)
        self.grain = Grain()

    def draw_noise(self, slabs, *, rng):
        """Noise of one pass, given the slab of each pixel (patch, range_bin, range_line).

        A dict of tensors (patch, channel, range_bin, range_line): that of `Grain.draw`; ``slab``,
        the same throughout a slab.
        """
        noise = self.grain.draw(slabs > 0, rng=rng)
        n_patches = len(slabs)
        levels = rng.standard_normal((n_patches, slabs.max() + 1), dtype=np.float32)
        level = np.take_along_axis(levels, slabs.reshape(n_patches, -1), axis=1)
        noise["slab"] = torch.from_numpy(level.reshape(n_patches, 1, *slabs.shape[1:]))
        return noise

    def forward(self, inputs, noise):
        """Image of some inputs, given the noise of `draw_noise`."""
        height, width = inputs.shape[2:]
        inputs = torch.cat([inputs, noise["slab"].to(inputs)], dim=1)
        beyond = (0, -width % self.multiple, 0, -height % self.multiple)
        inputs = functional.pad(inputs, beyond, mode="replicate")
        inputs[:, 0, height:] = -1.0
        features = functional.relu(self.unet(inputs))
        joined = torch.cat([features, inputs.to(features)], dim=1)
        return torch.tanh(self.last(joined))[:, :, :height, :width]


def networks(settings):
    """Generator and discriminator, not initialised."""
    generator = Generator(settings.width, settings.depth)
    return generator, PatchDiscriminator(settings.width, N_CHANNELS)


def learning_rate(settings, step):
    """Learning rate after `step` steps: constant for half of all steps, then linear to zero."""
    half = settings.n_steps // 2
    share_left = (settings.n_steps - step) / (settings.n_steps - half)
    return settings.learning_rate * min(1.0, share_left)


def prepared(scene, settings):
    """The scene and the level of its snow, which all batches of the scene share."""
    check_trainable(scene)
    return scene, snow_level(scene.image)


def draw_batch(generator, ready, settings, *, rng):
    """Batch of a random crop of a scene, as `prepared`, turned left to right half of the time.

    Tensors (patch, channel, range_bin, range_line): `inputs`, what both networks know, and `image`,
    as observed, in [-1, 1]; `noise`, a dict.
    """
    scene, of_snow = ready

    def known(scene):
        return known_map(scene.image, scene.layer_bins, of_snow)

    size = (settings.n_range_bins, settings.n_range_lines)
    image, _, crop = draw_patches([scene], *size, known=known, rng=rng)
    # Half a grey level of dither: otherwise the discriminator would recognise observed images by
    # their whole numbers.
    dither = rng.random(image.shape, dtype=np.float32) - np.float32(0.5)
    observed = to_signed(image) + torch.from_numpy(dither[:, None] / 127.5)
    inputs, slabs = inputs_of(crop)
    noise = generator.draw_noise(slabs, rng=rng)
    return {"inputs": inputs, "image": observed, "noise": noise}


def take_step(training, batch):
    """Update both networks, and the grain, on one batch; the losses before."""
    generator = training.generator
    known, observed, noise = (batch[name] for name in ("inputs", "image", "noise"))

    def decide_both(image):
        with arithmetic(training.device, training.settings.precision):
            # Normalised together: by themselves, renders of twice the contrast are the same to it.
            inputs = torch.cat([known, known])
            images = torch.cat([observed, image])
            return training.discriminator(inputs, images).chunk(2)

    def decide_rendered(image):
        return decide_both(image)[1]

    with arithmetic(training.device, training.settings.precision):
        rendered = generator(known, noise)
    rendered = rendered.float()
    # Before grain is added: the least error is an image without any. Grain has the moments of what
    # the image lacks, not its pixels.
    l1 = functional.l1_loss(rendered, observed)
    lacking = (observed - rendered).detach()
    generator.grain.mismatch(lacking, is_snow(known)).backward()
    rendered = rendered + generator.grain(noise).detach()
    return update(training, rendered, l1, decide_both, decide_rendered)


def render_image(generator, scene, settings, *, rng):
    """Image of a scene with echoes, float tensor (range_bin, range_line) in [-1, 1]."""
    expected = expected_image(scene)
    known = known_map(expected, scene.layer_bins, snow_level(expected))
    inputs, slabs = inputs_of(known[None])
    noise = generator.draw_noise(slabs, rng=rng)
    device = next(generator.parameters()).device
    with torch.inference_mode(), arithmetic(device, settings.precision):
        image = generator(inputs.to(device), noise) + generator.grain(noise)
    image = image[0, 0].float()
    # The maximum of an observed image is white, by its scaling: stretch the image to that.
    return (image + 1) * (2 / (image.max() + 1)) - 1
