"""pix2pix as its paper describes it: Isola, Zhu, Zhou & Efros (2017), CVPR; the recipe `paper`."""

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from snowsim.cgan.inputs import Batch
from snowsim.cgan.networks import SLOPE, adversarial_loss, halving, stage_channels
from snowsim.patches import check_trainable, to_signed
from snowsim.training import arithmetic

ENLARGED = 286 / 256  # a scene is resized to this much more than the crop that is cut out of it
N_NOISY_STAGES = 3  # of the decoder that drop out, from the innermost on


class Pix2PixGenerator(nn.Module):
    """U-Net from masks to images, (patch, 1, range_bin, range_line) in [-1, 1].

    Encoder channels ``width * (1, 2, 4, 8, 8, ...)``, `depth` halvings, of which sizes must be
    multiples. The outermost stages and the innermost of the encoder are not normalised.
    """

    def __init__(self, width=64, depth=8):
        super().__init__()
        self.channels = stage_channels(width, depth)
        self.down = nn.ModuleList()
        self.up = nn.ModuleList()
        n_outside = 1
        for stage, n_inside in enumerate(self.channels):
            self.down.append(halving(n_outside, n_inside))
            # The innermost stage has no skip.
            n_joined = n_inside if stage == depth - 1 else 2 * n_inside
            has_bias = stage == 0
            doubling = nn.ConvTranspose2d(n_joined, n_outside, 4, 2, padding=1, bias=has_bias)
            self.up.append(doubling)
            n_outside = n_inside
        self.norm_down = nn.ModuleList(_norm(n) for n in self.channels[1:-1])
        self.norm_up = nn.ModuleList(_norm(n) for n in self.channels[:-1])

    def draw_noise(self, shape, *, dropout=0.5, rng):
        """Dropout of one pass by stage, 0 or 1 / (1 - dropout).

        For masks of `shape` (patch, channel, range_bin, range_line).
        """
        n_patches, _, n_range_bins, n_range_lines = shape
        innermost = len(self.channels) - 1
        noise = {}
        for stage in range(innermost, max(innermost - N_NOISY_STAGES, 0), -1):
            size = (n_range_bins >> stage, n_range_lines >> stage)
            kept = rng.random((n_patches, self.channels[stage - 1], *size)) >= dropout
            noise[stage] = torch.from_numpy(kept / np.float32(1 - dropout))
        return noise

    def forward(self, masks, noise):
        """Images of some masks, given the noise of `draw_noise`."""
        kept = [self.down[0](masks)]
        for halve, norm in zip(self.down[1:-1], self.norm_down, strict=True):
            rectified = functional.leaky_relu(kept[-1], SLOPE)
            kept.append(norm(halve(rectified)))
        x = self.down[-1](functional.leaky_relu(kept[-1], SLOPE))
        for stage in range(len(kept), 0, -1):
            x = self.up[stage](functional.relu(x))
            x = self.norm_up[stage - 1](x)
            if stage in noise:
                x = x * noise[stage].to(x)
            x = torch.cat([kept[stage - 1], x], dim=1)
        return torch.tanh(self.up[0](functional.relu(x)))


def _norm(n_channels):
    """Normalisation by the images at hand, in training and in rendering."""
    return nn.BatchNorm2d(n_channels, track_running_stats=False)


def resized(images, size):
    """Images (patch, 1, range_bin, range_line) at another `size`."""
    return functional.interpolate(images, size=size, mode="bilinear", antialias=True)


def jittered(scene, settings, *, rng):
    """Mask and image of a scene in [-1, 1], resized to more than the crop, cut and mirrored.

    (2, 1, range_bin, range_line).
    """
    check_trainable(scene)
    sizes = (settings.n_range_bins, settings.n_range_lines)
    enlarged = [round(ENLARGED * size) for size in sizes]
    pair = torch.cat([to_signed(scene.mask()[None]), to_signed(scene.image[None])])
    whole = resized(pair, enlarged)
    row, line = (int(rng.integers(n + 1 - size)) for n, size in zip(enlarged, sizes, strict=True))
    crop = whole[..., row : row + sizes[0], line : line + sizes[1]]
    return crop.flip(-1) if rng.random() < 0.5 else crop


def draw_batch(generator, scenes, settings, *, rng):
    """`Batch` of some scenes."""
    pairs = [jittered(scene, settings, rng=rng) for scene in scenes]
    inputs, image = torch.stack(pairs, dim=1)
    noise = generator.draw_noise(inputs.shape, dropout=settings.dropout, rng=rng)
    return Batch(inputs, image, noise)


def update(training, batch):
    """Update the discriminator, then the generator on one batch; the losses before each."""
    settings = training.settings
    discriminator = training.discriminator
    with arithmetic(training.device, settings.precision):
        rendered = training.generator(batch.inputs, batch.noise).to(batch.image)
        real = discriminator(batch.inputs, batch.image)
        fake = discriminator(batch.inputs, rendered.detach())
    on_real = adversarial_loss(real, 1.0)
    on_fake = adversarial_loss(fake, 0.0)
    (0.5 * (on_real + on_fake)).backward()
    training.optimisers["discriminator_adam"].step()
    discriminator.requires_grad_(False)
    with arithmetic(training.device, settings.precision):
        decision = discriminator(batch.inputs, rendered)
    adversarial = adversarial_loss(decision, 1.0)
    l1 = functional.l1_loss(rendered, batch.image)
    (adversarial + settings.l1_weight * l1).backward()
    training.optimisers["generator_adam"].step()
    discriminator.requires_grad_(True)
    return {
        "discriminator_real": on_real,
        "discriminator_fake": on_fake,
        "generator_adversarial": adversarial,
        "l1": l1,
    }


def render_image(generator, scene, settings, *, rng):
    """Image of a scene's mask, float tensor (range_bin, range_line) in [-1, 1].

    The mask is resized to the size of the crops and the image back. Dropout stays on.
    """
    mask = to_signed(scene.mask()[None])
    inputs = resized(mask, (settings.n_range_bins, settings.n_range_lines))
    noise = generator.draw_noise(inputs.shape, dropout=settings.dropout, rng=rng)
    device = next(generator.parameters()).device
    with torch.inference_mode(), arithmetic(device, settings.precision):
        image = generator(inputs.to(device), noise).float()
    return resized(image, mask.shape[2:])[0, 0]
