"""The recipe `paper`: pix2pix as Isola, Zhu, Zhou & Efros (2017), CVPR, describe it."""

from functools import partial

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from snowsim.cgan.networks import PatchDiscriminator, UNet, batch_norm, update
from snowsim.patches import check_trainable, to_signed
from snowsim.training import arithmetic

ENLARGED = 286 / 256  # a scene is resized to this much more than the crop that is cut out of it
N_NOISY_STAGES = 3  # stages of the decoder with dropout, counted from the innermost
DROPOUT = 0.5


class Generator(nn.Module):
    """U-Net from masks to images, (patch, 1, range_bin, range_line) in [-1, 1].

    Sizes must be multiples of ``2**depth``.
    """

    def __init__(self, width=64, depth=8):
        super().__init__()
        doubling = partial(nn.ConvTranspose2d, kernel_size=4, stride=2, padding=1)
        self.unet = UNet(1, 1, width, depth, norm=batch_norm, doubling=doubling)

    def draw_noise(self, shape, *, rng):
        """Dropout of one pass by stage, 0 or 2, for masks of `shape`.

        `shape` is (patch, channel, range_bin, range_line).
        """
        n_patches, _, n_range_bins, n_range_lines = shape
        channels = self.unet.channels
        innermost = len(channels) - 1
        noise = {}
        for stage in range(innermost, max(innermost - N_NOISY_STAGES, 0), -1):
            size = (n_range_bins >> stage, n_range_lines >> stage)
            kept = rng.random((n_patches, channels[stage - 1], *size)) >= DROPOUT
            noise[stage] = torch.from_numpy(kept / np.float32(1 - DROPOUT))
        return noise

    def forward(self, masks, noise):
        """Images of some masks, given the noise of `draw_noise`."""
        return torch.tanh(self.unet(masks, noise))


def networks(settings):
    """Generator and discriminator, not initialised."""
    return Generator(settings.width, settings.depth), PatchDiscriminator(settings.width)


def learning_rate(settings, step):
    """Learning rate, the same at every step."""
    return settings.learning_rate


def resized(images, size):
    """Images (patch, 1, range_bin, range_line) at another `size`."""
    return functional.interpolate(images, size=size, mode="bilinear", antialias=True)


def prepared(scene, settings):
    """Mask and image of a scene in [-1, 1], resized to more than the crop.

    (2, 1, range_bin, range_line).
    """
    check_trainable(scene)
    enlarged = [round(ENLARGED * size) for size in (settings.n_range_bins, settings.n_range_lines)]
    pair = torch.cat([to_signed(scene.mask()[None]), to_signed(scene.image[None])])
    return resized(pair, enlarged)


def jittered(whole, settings, *, rng):
    """A random crop of mask and image as `prepared`, turned left to right half of the time."""
    sizes = (settings.n_range_bins, settings.n_range_lines)
    enlarged = whole.shape[2:]
    row, line = (int(rng.integers(n + 1 - size)) for n, size in zip(enlarged, sizes, strict=True))
    crop = whole[..., row : row + sizes[0], line : line + sizes[1]]
    return crop.flip(-1) if rng.random() < 0.5 else crop


def draw_batch(generator, ready, settings, *, rng):
    """Batch of one scene as `prepared`, as that of `snowsim.cgan.measured.draw_batch`."""
    inputs, image = jittered(ready, settings, rng=rng)[:, None]
    noise = generator.draw_noise(inputs.shape, rng=rng)
    return {"inputs": inputs, "image": image, "noise": noise}


def take_step(training, batch):
    """Update both networks on one batch; the losses before."""
    masks, observed = batch["inputs"], batch["image"]

    def decide(image):
        with arithmetic(training.device, training.settings.precision):
            return training.discriminator(masks, image)

    def decide_both(image):
        return decide(observed), decide(image)

    with arithmetic(training.device, training.settings.precision):
        rendered = training.generator(masks, batch["noise"])
    rendered = rendered.to(observed)
    l1 = functional.l1_loss(rendered, observed)
    return update(training, rendered, l1, decide_both, decide)


def render_image(generator, scene, settings, *, rng):
    """Image of a scene's mask, float tensor (range_bin, range_line) in [-1, 1].

    The mask is resized to the size of the crops and the image back. Dropout stays on.
    """
    mask = to_signed(scene.mask()[None])
    inputs = resized(mask, (settings.n_range_bins, settings.n_range_lines))
    noise = generator.draw_noise(inputs.shape, rng=rng)
    device = next(generator.parameters()).device
    with torch.inference_mode(), arithmetic(device, settings.precision):
        image = generator(inputs.to(device), noise).float()
    return resized(image, mask.shape[2:])[0, 0]
