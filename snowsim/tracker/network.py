"""Networks of the tracker, their loss, and the probabilities that they give.

Each network is an encoder shaped like VGG16 with a side output at each stage. The fused output is a
weighted sum of the side outputs.
"""

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn
from torch.nn import functional

from snowsim.patches import to_signed
from snowsim.training import arithmetic

# Channels of each stage as a multiple of the width, and number of its convolutions, as in VGG16.
STAGES = ((1, 2), (2, 2), (4, 3), (8, 3), (8, 3))


class MultiScaleNetwork(nn.Module):
    """A network that maps an image to layer logits at each of five scales, and fused.

    It is that of Rahnemoonfar, Yari, Paden, Koenig & Ibikunle (2021), J. Glaciol. 67(261): VGG16
    without its classifier and without batch normalisation; a 1x1 convolution on each stage, whose
    map is enlarged to the image; and a 1x1 convolution over the five maps. The published `width`,
    the number of channels of the first stage, is 64. Pooling keeps odd edges (ceil mode), and
    enlarged maps are cut on the right and below, so that pixel (0, 0) stays in its place at any
    image size. One step is not in the paper: the network can average every `n_averaged` range lines
    first; maps are then enlarged along track by that factor as well.
    """

    kind = "multi_scale"  # of `Settings.network`

    def __init__(self, width=64, n_averaged=1):
        super().__init__()
        self.width = width
        self.n_averaged = n_averaged
        self.stages = nn.ModuleList()
        self.sides = nn.ModuleList()
        n_in = 1
        for multiple, n_convolutions in STAGES:
            n_out = width * multiple
            stage = nn.ModuleList()
            for _ in range(n_convolutions):
                stage.append(nn.Conv2d(n_in, n_out, 3, padding=1))
                n_in = n_out
            self.stages.append(stage)
            self.sides.append(nn.Conv2d(n_out, 1, 1))
        self.fuse = nn.Conv2d(len(STAGES), 1, 1)

    def forward(self, image):
        """Logits, (output, patch, 1, range_bin, range_line), of images made by `to_input`."""
        x = image
        if self.n_averaged > 1:
            # In ceil mode the last mean may have fewer lines.
            x = functional.avg_pool2d(image, (1, self.n_averaged), ceil_mode=True)
        maps = []
        for number, stage in enumerate(self.stages):
            if number:
                x = functional.max_pool2d(x, 2, stride=2, ceil_mode=True)
            for convolution in stage:
                x = functional.relu(convolution(x))
            maps.append(x)
        logits = []
        for number, (side, x) in enumerate(zip(self.sides, self.merged(maps), strict=True)):
            factors = (2**number, 2**number * self.n_averaged)
            logits.append(self.enlarged(side(x).float(), factors, image.shape[2:]))
        sides = torch.stack(logits)
        # A weighted sum is the 1x1 convolution that fuses maps, without stacking them as channels.
        fused = torch.tensordot(self.fuse.weight.flatten(), sides, 1).float() + self.fuse.bias
        return torch.cat([sides, fused[None]])

    def merged(self, maps):
        """Inputs of the side outputs, finest first: the map of each stage."""
        return maps

    @staticmethod
    def to_input(images):
        """Input of the network, float32 (patch, 1, range_bin, range_line), from uint8 images."""
        return to_signed(images)

    @staticmethod
    def enlarged(logit, factors, size):
        """Maps enlarged by `factors` about pixel centres, then cut to the image's `size`."""
        return enlarge(logit, factors)[:, :, : size[0], : size[1]]

    def initialise(self, *, rng):
        """Draw weights as He et al. (2015) do, those of sides with s.d. 0.01; fuse is a mean."""
        with torch.no_grad():
            for name, parameter in self.named_parameters():
                if name.endswith("bias"):
                    parameter.zero_()
                elif name.startswith("fuse"):
                    parameter.fill_(1 / len(STAGES))
                else:
                    n_inputs = parameter[0].numel()
                    spread = 0.01 if name.startswith("sides") else np.sqrt(2 / n_inputs)
                    drawn = rng.standard_normal(tuple(parameter.shape), dtype=np.float32)
                    parameter.copy_(torch.from_numpy(np.float32(spread) * drawn))


class PyramidNetwork(MultiScaleNetwork):
    """A multi-scale network whose fine stages also use the maps of coarse ones.

    It is not in the paper. A 1x1 convolution gives each stage half as many channels as the first
    stage has; the enlarged map of the next coarser stage is added: the top-down path of Lin et al.
    (2017), CVPR, sections 3 and 6.
    """

    kind = "pyramid"

    def __init__(self, width=64, n_averaged=1):
        super().__init__(width, n_averaged)
        n_merged = (width + 1) // 2
        laterals = (nn.Conv2d(side.in_channels, n_merged, 1) for side in self.sides)
        self.laterals = nn.ModuleList(laterals)
        self.sides = nn.ModuleList(nn.Conv2d(n_merged, 1, 1) for _ in STAGES)

    def merged(self, maps):
        """Inputs of the side outputs, finest first: sums over a stage and all coarser ones."""
        found = []
        for lateral, x in zip(self.laterals[::-1], maps[::-1], strict=True):
            x = lateral(x)
            if found:
                x = x + MultiScaleNetwork.enlarged(found[-1], (2, 2), x.shape[2:])
            found.append(functional.relu(x))
        return found[::-1]


def enlarge(x, factors, *, align_corners=False):
    """Maps (patch, channel, row, column) enlarged bilinearly by `factors` (row, column)."""
    if factors == (1, 1):
        return x
    scale = tuple(float(factor) for factor in factors)
    return functional.interpolate(
        x, scale_factor=scale, mode="bilinear", align_corners=align_corners
    )


def track(
    network: torch.nn.Module, image: NDArray[np.uint8], *, precision: str = "float32"
) -> NDArray[np.float32]:
    """Probability of a layer from each of `OUTPUTS`, float32 (output, range_bin, range_line).

    `network` is a `trained_network`. `image` is uint8 (range_bin, range_line) of any size;
    ValueError if it has no contrast. `precision` of the arithmetic is `float32` or `bfloat16`.
    """
    return torch.sigmoid(_logits(network, image, precision)).cpu().numpy()


def logits_of(network, image, *, precision="float32"):
    """Logits of a layer before calibration; shape and arguments as of `track`."""
    return _logits(network, image, precision).cpu().numpy()


def fused_logits(network, image):
    """Fused logits of a uint8 image before calibration, float32 (range_bin, range_line)."""
    return logits_of(network, image)[-1]


def _logits(network, image, precision):
    """Logits of an image as tensor, float32 (output, range_bin, range_line)."""
    image = np.asarray(image)
    is_image = image.dtype == np.uint8 and image.ndim == 2 and image.size > 0
    if not (is_image and image.min() < image.max()):
        msg = (
            "image must be uint8 (range_bin, range_line) with contrast, "
            f"got {image.dtype} of shape {image.shape}"
        )
        raise ValueError(msg)
    device = next(network.parameters()).device
    with torch.inference_mode(), arithmetic(device, precision):
        logits = network(network.to_input(image[None]).to(device))
        return logits[:, 0, 0].float()


def cost_of_logits(logits, layer):
    """Cross-entropy of each pixel of logit z and class y, 0 or 1: ``log(1 + exp((1 - 2 y) z))``."""
    return functional.softplus((1 - 2 * layer) * logits.float())


def balanced_cross_entropy(logits, masks, *, layer_share=None, cost=cost_of_logits):
    """Class-balanced cross-entropy of each output, a sum over pixels and mean of images, (output,).

    `logits` are (output, patch, 1, range_bin, range_line), `masks` bool (patch, range_bin,
    range_line). Layers are weighted by the share of background and background by the share of
    layers: Xie & Tu (2015), ICCV, eq. (2). That share is `layer_share` in every image, or each
    image's own if None. `cost` is the cross-entropy of each pixel, ``-y log s(z) - (1 - y) log(1 -
    s(z))``.
    """
    layer = masks[:, None].float()
    if layer_share is None:
        layer_share = layer.sum(dim=(1, 2, 3), keepdim=True) / masks[0].numel()
    weight = torch.where(masks[:, None], 1 - layer_share, layer_share)
    # A product of matrices needs only one array of the size of `logits`, the cost.
    return cost(logits, layer).flatten(1) @ weight.flatten() / masks.shape[0]
