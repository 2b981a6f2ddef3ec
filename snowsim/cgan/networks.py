"""The two networks of pix2pix: a U-Net generator with skips and a PatchGAN discriminator."""

import numpy as np
import torch
from torch import nn
from torch.nn import functional

SLOPE = 0.2  # of the leaky rectifiers, pix2pix
N_NOISY_BLOCKS = 3  # decoder blocks outside the innermost that drop out, pix2pix


class UNetGenerator(nn.Module):
    """U-Net of pix2pix from a layer mask to an image, both (patch, 1, range_bin, range_line) in [-1, 1].

    Isola, Zhu, Zhou & Efros (2017), CVPR; encoder channels ``width * (1, 2, 4, 8, 8, ...)``, `depth` halvings. Any
    image size: the mask is continued to a multiple of ``2**depth``, downwards without layers and sideways with its last
    range line, and the output cut back. Batch normalisation is by the images at hand in training, and in rendering by
    statistics that `train.settle_statistics` sets once.
    """

    def __init__(self, width=64, depth=8):
        super().__init__()
        if depth < 2 or width < 1:
            msg = f"a generator needs depth >= 2 and width >= 1, got depth {depth}, width {width}"
            raise ValueError(msg)
        self.depth = depth
        self.channels = [width * min(2**stage, 8) for stage in range(depth)]
        c = self.channels
        self.down = nn.ModuleList(
            [_halving(1, c[0], bias=True)] + [_halving(c[stage - 1], c[stage]) for stage in range(1, depth)]
        )
        self.up = nn.ModuleList(
            # The innermost stage has no skip; every other joins what came up with what went down.
            nn.ConvTranspose2d(c[stage] * (1 + (stage < depth - 1)), c[stage - 1], 4, stride=2, padding=1, bias=False)
            for stage in range(1, depth)
        )
        self.out = nn.ConvTranspose2d(2 * c[0], 1, 4, stride=2, padding=1)
        # Neither the outermost nor the innermost stage is normalised on the way down.
        self.norm_down = nn.ModuleDict({str(stage): _norm(c[stage]) for stage in range(1, depth - 1)})
        self.norm_up = nn.ModuleList(_norm(c[stage - 1]) for stage in range(1, depth))

    def noisy_stages(self):
        """Decoder stages that drop out, innermost first."""
        return range(self.depth - 2, max(self.depth - 2 - N_NOISY_BLOCKS, 0), -1)

    def draw_noise(self, n_patches, n_range_bins, n_range_lines, *, dropout=0.5, rng):
        """Dropout of one pass, the only noise of pix2pix: 0 or 1 / (1 - dropout) for masks of this shape.

        A dict by stage of tensors (patch, channel, row, column).
        """
        rows, columns = (-(-n // 2**self.depth) * 2**self.depth for n in (n_range_bins, n_range_lines))
        noise = {}
        for stage in self.noisy_stages():
            shape = (n_patches, self.channels[stage - 1], rows >> stage, columns >> stage)
            kept = rng.random(shape, dtype=np.float32) >= dropout
            noise[stage] = torch.from_numpy(kept * np.float32(1 / (1 - dropout)))
        return noise

    def forward(self, mask, noise, *, own_statistics=False):
        """Image of a mask, given the noise of `draw_noise`; normalised by the mask's own statistics or by kept ones."""
        n_range_bins, n_range_lines = mask.shape[2:]
        x = self._continued(mask)
        kept = []
        for stage, halve in enumerate(self.down):
            x = halve(functional.leaky_relu(x, SLOPE) if stage else x)
            if str(stage) in self.norm_down:
                x = _normalised(x, self.norm_down[str(stage)], own_statistics)
            kept.append(x)
        for stage in range(self.depth - 1, 0, -1):
            x = _normalised(self.up[stage - 1](functional.relu(x)), self.norm_up[stage - 1], own_statistics)
            if stage in noise:
                x = x * noise[stage].to(x)
            x = torch.cat([kept[stage - 1], x], dim=1)
        return torch.tanh(self.out(functional.relu(x)))[:, :, :n_range_bins, :n_range_lines]

    @property
    def is_settled(self):
        """Whether there are statistics to render with."""
        return all(norm.num_batches_tracked > 0 for norm in self.norms())

    def norms(self):
        """The normalisations that keep statistics."""
        return [*self.norm_down.values(), *self.norm_up]

    def _continued(self, mask):
        """The mask on a grid that `depth` halvings divide."""
        below, beside = (-n % 2**self.depth for n in mask.shape[2:])
        if beside:
            mask = functional.pad(mask, (0, beside, 0, 0), mode="replicate")
        return functional.pad(mask, (0, 0, 0, below), value=-1.0)


class PatchDiscriminator(nn.Module):
    """PatchGAN of pix2pix: logits, one per patch, for real (mask, image) pairs against rendered ones.

    Patches are 16, 34, 70 (as published) and 142 pixels wide for `n_strided`, the stages that halve, of 1 to 4.
    """

    def __init__(self, width=64, n_strided=3):
        super().__init__()
        if n_strided < 1 or width < 1:
            msg = f"a discriminator needs n_strided >= 1 and width >= 1, got n_strided {n_strided}, width {width}"
            raise ValueError(msg)
        c = [width * min(2**stage, 8) for stage in range(n_strided + 1)]
        layers = [nn.Conv2d(2, c[0], 4, stride=2, padding=1), nn.LeakyReLU(SLOPE)]
        for stage in range(1, n_strided + 1):
            stride = 2 if stage < n_strided else 1
            layers += [
                nn.Conv2d(c[stage - 1], c[stage], 4, stride=stride, padding=1, bias=False),
                nn.BatchNorm2d(c[stage], track_running_stats=False),
                nn.LeakyReLU(SLOPE),
            ]
        self.layers = nn.Sequential(*layers, nn.Conv2d(c[-1], 1, 4, padding=1))

    def forward(self, mask, image):
        """Logits, (patch, 1, row, column), of masks and images (patch, 1, range_bin, range_line) in [-1, 1]."""
        return self.layers(torch.cat([mask, image], dim=1))


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


def _halving(n_in, n_out, *, bias=False):
    return nn.Conv2d(n_in, n_out, 4, stride=2, padding=1, bias=bias)


def _norm(n_channels):
    return nn.BatchNorm2d(n_channels, momentum=None)  # keeps plain averages, not exponential ones


def _normalised(x, norm, own_statistics):
    """Batch normalisation as `norm` is set to do it, or by the statistics of `x` without keeping them."""
    if own_statistics:
        return functional.batch_norm(x, None, None, norm.weight, norm.bias, training=True, eps=norm.eps)
    return norm(x)
