"""A U-Net generator with skips that knows depths, and pix2pix's PatchGAN discriminator."""

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from snowsim.cgan.grain import Grain

SLOPE = 0.2  # of the leaky rectifiers, pix2pix
EPSILON = 1e-5
MOST_WEIGHTS = 32  # of a convolution, for each pixel, that are worth adding up
N_NOISY_BLOCKS = 3  # decoder blocks outside the innermost that drop out


class UNetGenerator(nn.Module):
    """U-Net, inputs to images: (patch, channel, range_bin, range_line) in [-1, 1].

    After pix2pix, Isola, Zhu, Zhou & Efros (2017), CVPR; encoder channels ``width * (1, 2, 4, 8, 8,
    ...)``, `depth` halvings; an image has one channel. Any image size: inputs, the mask first, are
    continued to a multiple of ``2**depth``, downwards without layers and sideways with the last
    range line, and the output cut back. Features are normalised over the channels of each pixel: an
    image depends on what is within ``3 * 2**depth`` pixels alone. Its inputs have a random level
    for each slab, and it doubles images before it convolves them (Odena, Dumoulin & Olah 2016,
    Distill): equal inputs leave no lattice. It learns a `grain` to be added to its images.
    """

    def __init__(self, width=64, depth=8, n_inputs=1):
        super().__init__()
        self.depth = depth
        self.channels = stage_channels(width, depth)
        n_inputs += 1  # the level of its slab
        # First weights are drawn in the order in which layers are named here.
        self._add_encoder(n_inputs)
        self._add_decoder()
        outermost = 2 * self.channels[0]
        n_last = max(width // 2, 1)
        self.out = ResizeConvolution(outermost, n_last, 3, padding=1)
        self.last = nn.Conv2d(n_last + n_inputs, 1, 3, padding=1)
        self.grain = Grain()
        self._add_norms()

    def _add_encoder(self, n_inputs):
        self.down = nn.ModuleList()
        for stage, n_out in enumerate(self.channels):
            self.down.append(halving(n_inputs, n_out, bias=stage == 0))
            n_inputs = n_out

    def _add_decoder(self):
        self.up = nn.ModuleList()
        for stage in range(1, self.depth):
            n_in = self.channels[stage]
            # The innermost stage has no skip; every other joins what came up with what went down.
            if stage < self.depth - 1:
                n_in *= 2
            n_out = self.channels[stage - 1]
            self.up.append(ResizeConvolution(n_in, n_out, 3, padding=1, bias=False))

    def _add_norms(self):
        self.norm_down = nn.ModuleDict()
        # Neither the outermost nor the innermost stage is normalised on the way down.
        for stage in range(1, self.depth - 1):
            self.norm_down[str(stage)] = Norm(self.channels[stage])
        self.norm_up = nn.ModuleList(Norm(n) for n in self.channels[:-1])

    def noisy_stages(self):
        """Decoder stages that drop out, innermost first."""
        first = self.depth - 2
        return range(first, max(first - N_NOISY_BLOCKS, 0), -1)

    def draw_noise(self, slabs, *, dropout=0.5, rng):
        """Noise of one pass for inputs of the shape of `slabs`, the slab of each pixel.

        `slabs` is (patch, range_bin, range_line). A dict of tensors (patch, channel, row, column):
        by stage dropout, 0 or 1 / (1 - dropout); that of `Grain.draw`; ``slab``, the same
        throughout a slab.
        """
        n_patches, n_range_bins, n_range_lines = slabs.shape
        rows = n_range_bins + self._lacking(n_range_bins)
        columns = n_range_lines + self._lacking(n_range_lines)
        noise = {}
        for stage in self.noisy_stages():
            shape = (n_patches, self.channels[stage - 1], rows >> stage, columns >> stage)
            kept = rng.random(shape, dtype=np.float32) >= dropout
            gain = np.float32(1 / (1 - dropout))
            noise[stage] = torch.from_numpy(kept * gain)
        noise |= self.grain.draw(slabs > 0, rng=rng)
        n_slabs = int(slabs.max()) + 1
        levels = rng.standard_normal((n_patches, n_slabs), dtype=np.float32)
        level = np.take_along_axis(levels, slabs.reshape(n_patches, -1), axis=1)
        noise["slab"] = torch.from_numpy(level.reshape(n_patches, 1, *slabs.shape[1:]))
        return noise

    def forward(self, inputs, noise):
        """Image of some inputs, given the noise of `draw_noise`."""
        n_range_bins, n_range_lines = inputs.shape[2:]
        inputs = torch.cat([inputs, noise["slab"].to(inputs)], dim=1)
        inputs = self._continued(inputs)
        features = self._decode(self._encode(inputs), noise)
        joined = torch.cat([functional.relu(features), inputs.to(features)], dim=1)
        return torch.tanh(self.last(joined))[:, :, :n_range_bins, :n_range_lines]

    def _encode(self, x):
        """Features of every stage, outermost first."""
        kept = []
        for stage, halve in enumerate(self.down):
            if stage > 0:
                x = functional.leaky_relu(x, SLOPE)
            x = halve(x)
            if str(stage) in self.norm_down:
                x = self.norm_down[str(stage)](x)
            kept.append(x)
        return kept

    def _decode(self, kept, noise):
        """Features of the image's size, from those that the encoder kept."""
        x = kept[-1]
        for stage in range(self.depth - 1, 0, -1):
            x = self.up[stage - 1](functional.relu(x))
            x = self.norm_up[stage - 1](x)
            if stage in noise:
                x = x * noise[stage].to(x)
            x = torch.cat([kept[stage - 1], x], dim=1)
        return self.out(functional.relu(x))

    def _lacking(self, length):
        """How many pixels a side of this length lacks for `depth` halvings to divide it."""
        return -length % 2**self.depth

    def _continued(self, inputs):
        """The inputs on a grid that `depth` halvings divide."""
        below, beside = map(self._lacking, inputs.shape[2:])
        inputs = functional.pad(inputs, (0, beside, 0, below), mode="replicate")
        first_below = inputs.shape[2] - below
        inputs[:, 0, first_below:] = -1.0
        return inputs


class PatchDiscriminator(nn.Module):
    """PatchGAN of pix2pix: logits, one per patch, for real (mask, image) pairs against rendered.

    Patches are 16, 34, 70 (as published) and 142 pixels wide for `n_strided`, the stages that
    halve, of 1 to 4.
    """

    def __init__(self, width=64, n_strided=3, n_inputs=1):
        super().__init__()
        channels = stage_channels(width, n_strided + 1)
        outermost = halving(n_inputs + 1, channels[0], bias=True)
        layers = [outermost, nn.LeakyReLU(SLOPE)]
        for stage in range(1, n_strided + 1):
            n_out = channels[stage]
            stride = 2 if stage < n_strided else 1
            options = {"stride": stride, "padding": 1, "bias": False}
            layers += [
                nn.Conv2d(channels[stage - 1], n_out, 4, **options),
                nn.BatchNorm2d(n_out, track_running_stats=False),
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
        size = x.shape[1:2]
        normed = functional.layer_norm(channels_last, size, self.weight, self.bias, EPSILON)
        return normed.permute(0, 3, 1, 2)


class ResizeConvolution(nn.Conv2d):
    """Every pixel doubled down and across, then convolved, 3x3 with zeros around.

    No doubled image is made. Rows 2i and 2i + 1 of the result see two rows of x each, with weights
    (w0, w1 + w2) and (w0 + w1, w2): four convolutions of 2x2, 16 products for 36. Those of odd rows
    and columns first, they fall into place one pixel late. Adding weights costs more than it saves
    where there are many for few pixels.
    """

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
            mean = np.float32(1 if parameter.ndim == 1 else 0)
            drawn = rng.standard_normal(tuple(parameter.shape), dtype=np.float32)
            weights = mean + np.float32(0.02) * drawn
            parameter.copy_(torch.from_numpy(weights))


def adversarial_loss(logits, target):
    """Mean cross-entropy of a map of logits that should all say `target`."""
    logits = logits.float() if logits.dtype == torch.bfloat16 else logits
    return functional.binary_cross_entropy_with_logits(logits, torch.full_like(logits, target))


def stage_channels(width, n_stages):
    """Channels of each stage, outermost first."""
    return [width * min(2**stage, 8) for stage in range(n_stages)]


def halving(n_in, n_out, *, bias=False):
    """Convolution that halves both sides of its images."""
    return nn.Conv2d(n_in, n_out, 4, stride=2, padding=1, bias=bias)
