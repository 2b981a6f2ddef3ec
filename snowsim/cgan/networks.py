"""Parts of the networks of both recipes: a U-Net, and pix2pix's PatchGAN discriminator."""

from functools import partial

import numpy as np
import torch
from torch import nn
from torch.nn import functional

SLOPE = 0.2  # of the leaky rectifiers, pix2pix
MOST_WEIGHTS = 32  # weights per pixel of a convolution, up to which adding them up pays
LOSSES = ("discriminator_real", "discriminator_fake", "generator_adversarial", "l1")
L1_WEIGHT = 100.0  # of the generator's loss, pix2pix
# Normalisation by the images at hand, in training and in rendering.
batch_norm = partial(nn.BatchNorm2d, track_running_stats=False)


class UNet(nn.Module):
    """U-Net of pix2pix, Isola, Zhu, Zhou & Efros (2017), CVPR.

    Images (patch, `n_inputs`, row, column) become images (patch, `n_outputs`, row, column), of
    which sizes must be multiples of ``2**depth``: `depth` halvings to ``width * (1, 2, 4, 8, 8,
    ...)`` channels, as many doublings, and skips. ``norm(n_channels)`` makes a normalisation,
    ``doubling(n_in, n_out, bias=...)`` a layer that doubles. The outermost stages and the innermost
    of the encoder are not normalised.
    """

    def __init__(self, n_inputs, n_outputs, width, depth, *, norm, doubling):
        super().__init__()
        self.channels = stage_channels(width, depth)
        self.down = nn.ModuleList()
        self.up = nn.ModuleList()
        n_down, n_up = n_inputs, n_outputs
        for stage, n_inside in enumerate(self.channels):
            self.down.append(halving(n_down, n_inside))
            # The innermost stage has no skip.
            n_joined = n_inside if stage == depth - 1 else 2 * n_inside
            self.up.append(doubling(n_joined, n_up, bias=stage == 0))
            n_down = n_up = n_inside
        self.norm_down = nn.ModuleList(map(norm, self.channels[1:-1]))
        self.norm_up = nn.ModuleList(map(norm, self.channels[:-1]))

    def forward(self, x, dropout=()):
        """Image of `x`; `dropout` maps stages to factors of the features that they give."""
        kept = [self.down[0](x)]
        for halve, norm in zip(self.down[1:-1], self.norm_down, strict=True):
            rectified = functional.leaky_relu(kept[-1], SLOPE)
            kept.append(norm(halve(rectified)))
        x = self.down[-1](functional.leaky_relu(kept[-1], SLOPE))
        for stage in range(len(kept), 0, -1):
            x = self.up[stage](functional.relu(x))
            x = self.norm_up[stage - 1](x)
            if stage in dropout:
                x = x * dropout[stage].to(x)
            x = torch.cat([kept[stage - 1], x], dim=1)
        return self.up[0](functional.relu(x))


class PatchDiscriminator(nn.Module):
    """PatchGAN of pix2pix: logits, one per patch of 70 pixels, for observed images and renders."""

    def __init__(self, width=64, n_inputs=1):
        super().__init__()
        channels = stage_channels(width, 4)
        outermost = halving(n_inputs + 1, channels[0], bias=True)
        layers = [outermost, nn.LeakyReLU(SLOPE)]
        for n_in, n_out, stride in zip(channels, channels[1:], (2, 2, 1), strict=False):
            layers += [
                nn.Conv2d(n_in, n_out, 4, stride, padding=1, bias=False),
                batch_norm(n_out),
                nn.LeakyReLU(SLOPE),
            ]
        layers.append(nn.Conv2d(channels[-1], 1, 4, padding=1))
        self.layers = nn.Sequential(*layers)

    def forward(self, inputs, image):
        """Logits, (patch, 1, row, column), of inputs and images as the generator's."""
        return self.layers(torch.cat([inputs, image], dim=1))


class Norm(nn.Module):
    """Normalisation of features (patch, channel, row, column) over the channels of each pixel.

    Each channel has gain and offset.
    """

    def __init__(self, n_channels):
        super().__init__()
        self.weight = nn.Parameter(torch.ones(n_channels))
        self.bias = nn.Parameter(torch.zeros(n_channels))

    def forward(self, x):
        """Features of mean 0 and variance 1 at each pixel, before gain and offset."""
        channels_last = x.permute(0, 2, 3, 1)
        normed = functional.layer_norm(channels_last, x.shape[1:2], self.weight, self.bias)
        return normed.permute(0, 3, 1, 2)


class ResizeConvolution(nn.Conv2d):
    """Every pixel doubled down and across, then convolved, 3x3 with zeros around.

    No doubled image is made. Rows 2i and 2i + 1 of the result see two rows of x each, with weights
    (w0, w1 + w2) and (w0 + w1, w2): four convolutions of 2x2, 16 products for 36. Those of odd rows
    and columns first, they fall into place one pixel late. Adding weights costs more than it saves
    where there are many for few pixels.
    """

    def __init__(self, n_in, n_out, *, bias=True):
        super().__init__(n_in, n_out, 3, padding=1, bias=bias)

    def forward(self, x):
        """Images (patch, channel, 2 row, 2 column) of `x`, (patch, channel, row, column)."""
        n_pixels = x.shape[2] * x.shape[3]
        if self.weight.numel() > MOST_WEIGHTS * n_pixels:
            return super().forward(functional.interpolate(x, scale_factor=2.0))
        kernels = self.weight
        for axis in (2, 4):
            first, middle, last = kernels.unbind(axis)
            odd = torch.stack([first + middle, last], axis)
            even = torch.stack([first, middle + last], axis)
            kernels = torch.stack([odd, even], axis // 2)
        bias = None if self.bias is None else self.bias.repeat_interleave(4)
        both = functional.conv2d(x, kernels.flatten(0, 2), bias, padding=1)
        return functional.pixel_shuffle(both, 2)[:, :, 1:-1, 1:-1]


def initialise(network, *, rng):
    """Draw the weights of pix2pix: convolutions N(0, 0.02), gains N(1, 0.02), biases 0."""
    with torch.no_grad():
        for name, parameter in network.named_parameters():
            if name.endswith("bias"):
                parameter.zero_()
                continue
            mean = np.float32(parameter.ndim == 1)
            shape = tuple(parameter.shape)
            drawn = rng.standard_normal(shape, dtype=np.float32)
            weights = mean + np.float32(0.02) * drawn
            parameter.copy_(torch.from_numpy(weights))


def update(training, rendered, l1, decide_both, decide_rendered):
    """Update the discriminator, then the generator; the losses before each.

    ``decide_both(image)`` gives logits of the observed images and of rendered ones,
    ``decide_rendered(image)`` of the latter. `rendered` and `l1`, the mean distance of renders from
    observed images, lead back to the generator. Losses:
    ``L_D = (A(observed, 1) + A(rendered, 0)) / 2`` and ``L_G = A(rendered, 1) + 100 l1``, A the
    cross-entropy of logits (0.69 is undecided): Isola et al. (2017), eq. (7) of Yari et al. (2021).
    """
    discriminator = training.discriminator
    real, fake = decide_both(rendered.detach())
    on_real = adversarial_loss(real, 1.0)
    on_fake = adversarial_loss(fake, 0.0)
    (0.5 * (on_real + on_fake)).backward()
    training.optimisers["discriminator_adam"].step()
    discriminator.requires_grad_(False)
    adversarial = adversarial_loss(decide_rendered(rendered), 1.0)
    (adversarial + L1_WEIGHT * l1).backward()
    training.optimisers["generator_adam"].step()
    discriminator.requires_grad_(True)
    return dict(zip(LOSSES, (on_real, on_fake, adversarial, l1), strict=True))


def adversarial_loss(logits, target):
    """Mean cross-entropy of a map of logits, all of which should be `target`."""
    logits = logits.float() if logits.dtype == torch.bfloat16 else logits
    return functional.binary_cross_entropy_with_logits(logits, torch.full_like(logits, target))


def stage_channels(width, n_stages):
    """Channels of each stage, outermost first."""
    return [width * min(2**stage, 8) for stage in range(n_stages)]


def halving(n_in, n_out, *, bias=False):
    """Convolution that halves both sides of its images."""
    return nn.Conv2d(n_in, n_out, 4, stride=2, padding=1, bias=bias)
