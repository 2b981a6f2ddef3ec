"""The two networks of pix2pix: a U-Net generator with skips and a PatchGAN discriminator."""

import numpy as np
import torch
from torch import nn
from torch.nn import functional

SLOPE = 0.2  # of the leaky rectifiers, pix2pix
EPSILON = 1e-5
MOST_WEIGHTS = 32  # of a convolution, for each pixel, that are worth adding up
N_NOISY_BLOCKS = 3  # decoder blocks outside the innermost that drop out, pix2pix


class UNetGenerator(nn.Module):
    """U-Net of pix2pix from inputs to an image, (patch, channel, range_bin, range_line) in [-1, 1], the image's one.

    Isola, Zhu, Zhou & Efros (2017), CVPR; encoder channels ``width * (1, 2, 4, 8, 8, ...)``,
    `depth` halvings. Any image size: inputs, the mask first, are continued to a multiple of
    ``2**depth``, downwards without layers and sideways with the last range line, and the output cut
    back. With `statistics` ``scene`` features are normalised by the images at hand, as published,
    with ``pixel`` over the channels of each pixel: then an image depends on what is within ``3 *
    2**depth`` pixels alone. With `is_noisy` its inputs have a random level for each slab, and it
    doubles images before it convolves them (Odena, Dumoulin & Olah 2016, Distill): equal inputs
    leave no lattice. With `has_grain` it learns a `grain` to be added to its images.
    """

    def __init__(
        self, width=64, depth=8, n_inputs=1, *, statistics="scene", is_noisy=False, has_grain=False
    ):
        super().__init__()
        if depth < 2 or width < 1:
            msg = f"a generator needs depth >= 2 and width >= 1, got depth {depth}, width {width}"
            raise ValueError(msg)
        self.depth, self.statistics, self.is_noisy, self.has_grain = (
            depth,
            statistics,
            is_noisy,
            has_grain,
        )
        self.channels = [width * min(2**stage, 8) for stage in range(depth)]
        c = self.channels
        self.down = nn.ModuleList(
            [_halving(n_inputs + is_noisy, c[0], bias=True)]
            + [_halving(c[stage - 1], c[stage]) for stage in range(1, depth)]
        )
        self.up = nn.ModuleList(
            # The innermost stage has no skip; every other joins what came up with what went down.
            _doubling(c[stage] * (1 + (stage < depth - 1)), c[stage - 1], resized=is_noisy)
            for stage in range(1, depth)
        )
        n_out = max(width // 2, 1) if is_noisy else 1
        self.out = _doubling(2 * c[0], n_out, resized=is_noisy, bias=True)
        if is_noisy:
            self.last = nn.Conv2d(n_out + n_inputs + 1, 1, 3, padding=1)
        if has_grain:
            self.grains = nn.Conv2d(
                1, 1, (5, 1), padding=(2, 0), bias=False
            )  # range lines are independent
            self.gains = nn.Conv2d(1, 1, 1, bias=False)  # of a range line as a whole
        # Neither the outermost nor the innermost stage is normalised on the way down.
        self.norm_down = nn.ModuleDict(
            {str(stage): Norm(c[stage]) for stage in range(1, depth - 1)}
        )
        self.norm_up = nn.ModuleList(Norm(c[stage - 1]) for stage in range(1, depth))

    def noisy_stages(self):
        """Decoder stages that drop out, innermost first."""
        return range(self.depth - 2, max(self.depth - 2 - N_NOISY_BLOCKS, 0), -1)

    def draw_noise(self, slabs, *, dropout=0.5, rng):
        """Noise of one pass for inputs of the shape of `slabs`, (patch, range_bin, range_line), the slab of each pixel.

        A dict of tensors (patch, channel, row, column): by stage dropout, 0 or 1 / (1 - dropout),
        the only noise of pix2pix; where the generator takes them ``white`` noise, and ``slab``, the
        same throughout a slab.
        """
        n_patches, *size = slabs.shape
        rows, columns = (-(-n // 2**self.depth) * 2**self.depth for n in size)
        noise = {}
        for stage in self.noisy_stages():
            shape = (n_patches, self.channels[stage - 1], rows >> stage, columns >> stage)
            kept = rng.random(shape, dtype=np.float32) >= dropout
            noise[stage] = torch.from_numpy(kept * np.float32(1 / (1 - dropout)))
        if self.has_grain:
            for name, n_rows in (("white", rows), ("line", 1)):
                drawn = rng.standard_normal((n_patches, 1, n_rows, columns), dtype=np.float32)
                noise[name] = torch.from_numpy(drawn)
        if self.is_noisy:
            levels = rng.standard_normal((n_patches, int(slabs.max()) + 1), dtype=np.float32)
            noise["slab"] = torch.from_numpy(
                np.take_along_axis(levels, slabs.reshape(n_patches, -1), 1).reshape(
                    n_patches, 1, *size
                )
            )
        return noise

    def forward(self, inputs, noise):
        """Image of some inputs, given the noise of `draw_noise`."""
        n_range_bins, n_range_lines = inputs.shape[2:]
        if self.is_noisy:
            inputs = torch.cat([inputs, noise["slab"].to(inputs)], dim=1)
        x = inputs = self._continued(inputs)
        kept = []
        for stage, halve in enumerate(self.down):
            x = halve(functional.leaky_relu(x, SLOPE) if stage else x)
            if str(stage) in self.norm_down:
                x = self.norm_down[str(stage)](x, self.statistics)
            kept.append(x)
        for stage in range(self.depth - 1, 0, -1):
            x = self.norm_up[stage - 1](self.up[stage - 1](functional.relu(x)), self.statistics)
            if stage in noise:
                x = x * noise[stage].to(x)
            x = torch.cat([kept[stage - 1], x], dim=1)
        x = self.out(functional.relu(x))
        if self.is_noisy:
            x = self.last(torch.cat([functional.relu(x), inputs.to(x)], dim=1))
        return torch.tanh(x)[:, :, :n_range_bins, :n_range_lines]

    def grain(self, noise, n_range_bins, n_range_lines):
        """What to add to an image of this size: filtered noise, alike everywhere as speckle and gain are in dB."""
        if not self.has_grain:
            return 0.0
        grain = self.grains(noise["white"].to(self.grains.weight)) + self.gains(
            noise["line"].to(self.gains.weight)
        )
        return grain[:, :, :n_range_bins, :n_range_lines]

    def _continued(self, inputs):
        """The inputs on a grid that `depth` halvings divide."""
        below, beside = (-n % 2**self.depth for n in inputs.shape[2:])
        inputs = functional.pad(inputs, (0, beside, 0, below), mode="replicate")
        inputs[:, 0, inputs.shape[2] - below :] = -1.0
        return inputs


class PatchDiscriminator(nn.Module):
    """PatchGAN of pix2pix: logits, one per patch, for real (mask, image) pairs against rendered ones.

    Patches are 16, 34, 70 (as published) and 142 pixels wide for `n_strided`, the stages that
    halve, of 1 to 4.
    """

    def __init__(self, width=64, n_strided=3, n_inputs=1):
        super().__init__()
        if n_strided < 1 or width < 1:
            msg = f"a discriminator needs n_strided >= 1 and width >= 1, got n_strided {n_strided}, width {width}"
            raise ValueError(msg)
        c = [width * min(2**stage, 8) for stage in range(n_strided + 1)]
        layers = [nn.Conv2d(n_inputs + 1, c[0], 4, stride=2, padding=1), nn.LeakyReLU(SLOPE)]
        for stage in range(1, n_strided + 1):
            stride = 2 if stage < n_strided else 1
            layers += [
                nn.Conv2d(c[stage - 1], c[stage], 4, stride=stride, padding=1, bias=False),
                nn.BatchNorm2d(c[stage], track_running_stats=False),
                nn.LeakyReLU(SLOPE),
            ]
        self.layers = nn.Sequential(*layers, nn.Conv2d(c[-1], 1, 4, padding=1))

    def forward(self, inputs, image):
        """Logits, (patch, 1, row, column), of inputs and images (patch, channel, range_bin, range_line) in [-1, 1]."""
        return self.layers(torch.cat([inputs, image], dim=1))


class Norm(nn.Module):
    """Normalisation of features (patch, channel, row, column), with a gain and an offset for each channel."""

    def __init__(self, n_channels):
        super().__init__()
        self.weight, self.bias = (
            nn.Parameter(torch.ones(n_channels)),
            nn.Parameter(torch.zeros(n_channels)),
        )

    def forward(self, x, statistics):
        """By mean and variance of each channel over the images (`scene`), or of each pixel over channels (`pixel`)."""
        if statistics == "scene":
            return functional.batch_norm(x, None, None, self.weight, self.bias, training=True)
        by_pixel = functional.layer_norm(
            x.permute(0, 2, 3, 1), x.shape[1:2], self.weight, self.bias, EPSILON
        )
        return by_pixel.permute(0, 3, 1, 2)


class ResizeConvolution(nn.Conv2d):
    """Every pixel doubled down and across, then convolved, 3x3 with zeros around; no doubled image is made.

    Rows 2i and 2i + 1 of the result see two rows of x each, with weights (w0, w1 + w2) and (w0 +
    w1, w2): four convolutions of 2x2, 16 products for 36. Those of odd rows and columns first, they
    fall into place one pixel late. Adding weights costs more than it saves where there are many for
    few pixels.
    """

    def forward(self, x):
        """Images (patch, channel, 2 row, 2 column) of `x`, (patch, channel, row, column)."""
        if self.weight.numel() > MOST_WEIGHTS * x.shape[2] * x.shape[3]:
            return super().forward(functional.interpolate(x, scale_factor=2.0))
        kernels = self.weight
        for axis in (2, 4):
            first, middle, last = kernels.unbind(axis)
            halves = (
                torch.stack([first + middle, last], axis),
                torch.stack([first, middle + last], axis),
            )
            kernels = torch.stack(halves, axis // 2)
        bias = None if self.bias is None else self.bias.repeat_interleave(4)
        both = functional.conv2d(x, kernels.flatten(0, 2), bias, padding=1)
        return functional.pixel_shuffle(both, 2)[:, :, 1:-1, 1:-1]


def initialise(network, *, rng):
    """Draw the weights of pix2pix: convolutions N(0, 0.02), normalisation gains N(1, 0.02), biases 0."""
    with torch.no_grad():
        for name, parameter in network.named_parameters():
            if name.endswith("bias"):
                parameter.zero_()
                continue
            mean = 1.0 if parameter.ndim == 1 else 0.0
            drawn = rng.standard_normal(tuple(parameter.shape), dtype=np.float32)
            parameter.copy_(torch.from_numpy(np.float32(mean) + np.float32(0.02) * drawn))


def _doubling(n_in, n_out, *, resized, bias=False):
    if resized:
        return ResizeConvolution(n_in, n_out, 3, padding=1, bias=bias)
    return nn.ConvTranspose2d(n_in, n_out, 4, stride=2, padding=1, bias=bias)


def _halving(n_in, n_out, *, bias=False):
    return nn.Conv2d(n_in, n_out, 4, stride=2, padding=1, bias=bias)
