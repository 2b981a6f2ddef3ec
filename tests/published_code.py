"""The published tracker code written again from its description, in plain PyTorch and SciPy.

github.com/BinaLab/MultiScale (`train.py`, `msnet/`, `modules/`): Rahnemoonfar et al. (2021).
Nothing of the package.
"""

import numpy as np
import torch
from scipy.ndimage import map_coordinates
from torch import nn

N_CONVOLUTIONS = (2, 2, 3, 3, 3)


class Net(nn.Module):
    """Five stages (`down`), their sides (`up`), the fuse; outputs are probabilities."""

    def __init__(self, width):
        super().__init__()
        self.down, self.up = nn.ModuleList(), nn.ModuleList()
        before = 1
        for multiple, n in zip((1, 2, 4, 8, 8), N_CONVOLUTIONS, strict=True):
            layers = []
            for _ in range(n):
                layers += [nn.Conv2d(before, multiple * width, kernel_size=3, padding=1), nn.ReLU()]
                before = multiple * width
            self.down.append(nn.Sequential(*layers))
            self.up.append(nn.Conv2d(before, 1, kernel_size=1))
        self.fuse = nn.Conv2d(5, 1, kernel_size=1)
        nn.init.constant_(self.fuse.weight, 0.2)
        nn.init.zeros_(self.fuse.bias)

    def forward(self, x):
        height, width = x.shape[-2:]
        pool = nn.MaxPool2d(2, 2, ceil_mode=True)
        sides = []
        for k in range(5):
            x = self.down[k](pool(x) if k else x)
            side = self.up[k](x)
            if k:
                side = nn.Upsample(scale_factor=2**k, mode="bilinear", align_corners=True)(side)
            y1 = int(round((side.shape[2] - height) / 2.0))
            x1 = int(round((side.shape[3] - width) / 2.0))
            sides.append(side[:, :, y1 : y1 + height, x1 : x1 + width])
        return [torch.sigmoid(z) for z in [*sides, self.fuse(torch.cat(sides, 1))]]


def parameter_groups(net, lr, decay):
    """Rates of `tune_lrs`.

    The key of the decay of stage 5's biases is misspelt, so they have the optimiser's.
    """
    groups = []
    for modules, factor in (
        (net.down[:4], 1),
        (net.down[4:], 100),
        (net.up, 0.01),
        ([net.fuse], 0.001),
    ):
        named = [item for module in modules for item in module.named_parameters()]
        weights, biases = ([p for name, p in named if kind in name] for kind in ("weight", "bias"))
        groups.append({"params": weights, "lr": lr * factor, "weight_decay": decay})
        groups.append({"params": biases, "lr": 2 * lr * factor})
        if factor != 100:
            groups[-1]["weight_decay"] = 0.0
    return groups


def rescaled(picture, rate):
    """OpenCV's bilinear resize of 8-bit values to a truncated size.

    Beyond centres of edge pixels nothing changes.
    """
    if rate == 1:
        return picture
    size = [int(n * rate) for n in picture.shape]
    at = []
    for m, n in zip(size, picture.shape, strict=True):
        centres = (np.arange(m) + 0.5) * n / m - 0.5
        at.append(np.clip(centres, 0, n - 1))
    values = map_coordinates(picture.astype(float), np.meshgrid(*at, indexing="ij"), order=1)
    return np.floor(np.round(values, 6) + 0.5).astype(np.uint8)


def copy_of(image, contour, transform):
    """One item of the loader: grey level less the mean, and the contours as numbers."""
    if transform == "fliplr":
        image, contour = image[:, ::-1], contour[:, ::-1]
    else:
        image, contour = rescaled(image, transform), rescaled(contour, transform)
    red, green, blue = 104.00698793, 116.66876762, 122.67891434
    grey = image.astype(np.float32) - np.float32(0.299 * red + 0.587 * green + 0.114 * blue)
    return torch.from_numpy(grey)[None, None], torch.from_numpy((contour > 0).astype(np.float32))[
        None, None
    ]


def cross_entropy(prediction, label):
    positive = label.sum()
    total = label.numel()
    weight = torch.where(label == 1, (total - positive) / total, positive / total)
    # The library's loss: logarithms cut at -100, no gradient where a probability is rounded to 0 or
    # 1.
    return nn.BCELoss(weight=weight, reduction="sum")(prediction, label)


def train(net, epochs, *, lr, decay, momentum, itersize, stepsize, step_by_epoch=False):
    """Train on lists of items an epoch; the sum of pixels of every output at every gradient.

    The code of 2020 steps its schedule by epochs, that of 2021 by updates.
    """
    optimiser = torch.optim.SGD(
        parameter_groups(net, lr, decay), lr=lr, momentum=momentum, weight_decay=decay
    )
    scheduler = torch.optim.lr_scheduler.StepLR(optimiser, step_size=stepsize, gamma=0.1)
    losses = []
    for items in epochs:
        counter = 0
        for image, label in items:
            of_outputs = [cross_entropy(output, label) for output in net(image)]
            (sum(of_outputs) / itersize).backward()
            losses.append([loss.item() for loss in of_outputs])
            counter += 1
            if counter == itersize:
                optimiser.step()
                optimiser.zero_grad()
                if not step_by_epoch:
                    scheduler.step()
                counter = 0
        if step_by_epoch:
            scheduler.step()
    return losses
