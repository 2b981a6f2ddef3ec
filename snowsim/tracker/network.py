"""The multi-scale network: a VGG16-shaped encoder with a side output per stage and their fusion."""

import numpy as np
import torch
from torch import nn
from torch.nn import functional

STAGES = ((1, 2), (2, 2), (4, 3), (8, 3), (8, 3))  # channels in units of the width, convolutions: VGG16


class MultiScaleNetwork(nn.Module):
    """Maps of layer logits at five scales and fused, from one image; `width` is 64 as published.

    Rahnemoonfar, Yari, Paden, Koenig & Ibikunle (2021), J. Glaciol. 67(261): VGG16 without its classifier and without
    batch normalisation, a 1x1 convolution on each stage, brought to the size of the image, a 1x1 convolution over the
    five. Pooling keeps odd edges (ceil mode); what is then too large by up to 15 pixels is cut, so that pixel (0, 0)
    stays where it is at any image size.
    """

    def __init__(self, width=64):
        super().__init__()
        if width < 1:
            msg = f"width must be at least 1, got {width}"
            raise ValueError(msg)
        self.stages = nn.ModuleList()
        self.sides = nn.ModuleList()
        n_in = 1
        for multiple, n_convolutions in STAGES:
            n_out = width * multiple
            sizes = [n_in] + [n_out] * n_convolutions
            self.stages.append(nn.ModuleList(nn.Conv2d(a, b, 3, padding=1) for a, b in zip(sizes, sizes[1:])))  # noqa: B905
            self.sides.append(nn.Conv2d(n_out, 1, 1))
            n_in = n_out
        self.fuse = nn.Conv2d(len(STAGES), 1, 1)

    def forward(self, image):
        """Logits of `OUTPUTS`, (output, patch, 1, range_bin, range_line), of images (patch, 1, ...) in [-1, 1]."""
        n_range_bins, n_range_lines = image.shape[2:]
        x = image
        logits = []
        for number, (stage, side) in enumerate(zip(self.stages, self.sides, strict=True)):
            if number:
                x = functional.max_pool2d(x, 2, stride=2, ceil_mode=True)
            for convolution in stage:
                x = functional.relu(convolution(x))
            logit = side(x).float()
            if number:
                logit = functional.interpolate(logit, scale_factor=2.0**number, mode="bilinear", align_corners=False)
            logits.append(logit[:, :, :n_range_bins, :n_range_lines])
        logits.append(self.fuse(torch.cat(logits, dim=1)).float())
        return torch.stack(logits)


class LightNetwork(nn.Module):
    """The same outputs from a light U-Net: one convolution a stage on the way down and one on the way up.

    Side output k reads stage k on the way up, so that the finest has seen the coarsest; about the cost of a
    `MultiScaleNetwork` of the same width, whose side outputs know their own scale and finer ones alone. Ronneberger,
    Fischer & Brox (2015), MICCAI, with 1x1 projections added to the skips instead of concatenation.
    """

    def __init__(self, width=8):
        super().__init__()
        if width < 1:
            msg = f"width must be at least 1, got {width}"
            raise ValueError(msg)
        sizes = [multiple * width for multiple, _ in STAGES]
        self.stages = nn.ModuleList(nn.Conv2d(a, b, 3, padding=1) for a, b in zip([1, *sizes], sizes, strict=False))
        self.stages_across = nn.ModuleList(nn.Conv2d(b, a, 1) for a, b in zip(sizes, sizes[1:], strict=False))
        self.stages_up = nn.ModuleList(nn.Conv2d(n, n, 3, padding=1) for n in sizes)
        self.sides = nn.ModuleList(nn.Conv2d(n, 1, 1) for n in sizes)
        self.fuse = nn.Conv2d(len(STAGES), 1, 1)

    def forward(self, image):
        """Logits of `OUTPUTS`, as `MultiScaleNetwork.forward`."""
        n_range_bins, n_range_lines = image.shape[2:]
        x, down = image, []
        for number, convolution in enumerate(self.stages):
            if number:
                x = functional.max_pool2d(x, 2, stride=2, ceil_mode=True)
            x = functional.relu(convolution(x))
            down.append(x)
        logits = []
        for number in reversed(range(len(STAGES))):
            skip = down[number]
            if number + 1 < len(STAGES):
                skip = skip + _doubled(self.stages_across[number](x))[:, :, : skip.shape[2], : skip.shape[3]]
            x = functional.relu(self.stages_up[number](skip))
            logit = self.sides[number](x).float()
            if number:
                logit = functional.interpolate(logit, scale_factor=2.0**number, mode="bilinear", align_corners=False)
            logits.insert(0, logit[:, :, :n_range_bins, :n_range_lines])
        logits.append(self.fuse(torch.cat(logits, dim=1)).float())
        return torch.stack(logits)


def _doubled(x):
    return functional.interpolate(x, scale_factor=2.0, mode="bilinear", align_corners=False)


NETWORKS = {"multi_scale": MultiScaleNetwork, "unet": LightNetwork}


def initialise(network, *, rng):
    """Draw the weights: He et al. (2015) for the stages, N(0, 0.01) for the sides, a mean for the fuse."""
    with torch.no_grad():
        for name, parameter in network.named_parameters():
            if name.endswith("bias"):
                parameter.zero_()
            elif name.startswith("fuse"):
                parameter.fill_(1 / len(STAGES))
            else:
                n_inputs = parameter[0].numel()
                spread = np.sqrt(2 / n_inputs) if name.startswith("stages") else 0.01
                drawn = rng.standard_normal(tuple(parameter.shape), dtype=np.float32)
                parameter.copy_(torch.from_numpy(np.float32(spread) * drawn))
