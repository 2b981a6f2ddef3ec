"""The published code of pix2pix written again from its description: passes by hand, no optimiser.

github.com/phillipi/pix2pix (`models.lua`, `train.lua`, `data/donkey_folder.lua`) before March 2017,
`image.scale` and `optim.adam` of Torch: Isola et al. (2017). Nothing of the package.
"""

import math

import numpy as np
import torch
from torch import nn
from torch.nn import functional as F


class Generator(nn.Module):
    """Stages `e1`, `e2`, ... down and `d1`, `d2`, ... up, the innermost first on the way up."""

    def __init__(self, ngf, n_stages):
        super().__init__()
        self.n = n_stages
        size = [1] + [ngf * min(2**k, 8) for k in range(n_stages)]
        for k in range(1, n_stages + 1):
            self.add_module(f"e{k}", nn.Conv2d(size[k - 1], size[k], 4, 2, 1))
            if k > 1:
                self.add_module(f"e{k}_norm", Normalise(size[k]))
        for k in range(1, n_stages + 1):
            n_in = size[n_stages + 1 - k] * (1 if k == 1 else 2)
            n_out = size[n_stages - k]
            self.add_module(f"d{k}", nn.ConvTranspose2d(n_in, n_out, 4, 2, 1))
            if k < n_stages:
                self.add_module(f"d{k}_norm", Normalise(n_out))

    def forward(self, x, dropped):
        """`dropped`: what the drop-outs of `d1`, `d2`, ... multiply with."""
        encoded = []
        for k in range(1, self.n + 1):
            x = getattr(self, f"e{k}")(x if k == 1 else torch.where(x > 0, x, 0.2 * x))
            if k > 1:
                x = getattr(self, f"e{k}_norm").apply_to(x)
            encoded.append(x)
        for k in range(1, self.n + 1):
            x = getattr(self, f"d{k}")(torch.where(x > 0, x, 0.0))
            if k < self.n:
                x = getattr(self, f"d{k}_norm").apply_to(x)
                if k <= len(dropped):
                    x = x * dropped[k - 1]
                x = torch.cat([x, encoded[self.n - 1 - k]], 1)
        return torch.tanh(x)


class Normalise(nn.Module):
    """Batch normalisation that always uses the batch."""

    def __init__(self, n):
        super().__init__()
        self.weight = nn.Parameter(torch.ones(n))
        self.bias = nn.Parameter(torch.zeros(n))

    def apply_to(self, x):
        mean = x.mean((0, 2, 3), keepdim=True)
        variance = ((x - mean) ** 2).mean((0, 2, 3), keepdim=True)
        scaled = (x - mean) / torch.sqrt(variance + 1e-5)
        return scaled * self.weight[None, :, None, None] + self.bias[None, :, None, None]


class Convolution:
    """Keeps its input; gradients are added up."""

    def __init__(self, weight, bias, stride):
        self.parameters, self.stride = [weight, bias], stride
        self.gradients = [torch.zeros_like(p) for p in self.parameters]

    def forward(self, x):
        self.x = x
        return F.conv2d(x, *self.parameters, stride=self.stride, padding=1)

    def backward(self, g, *, adds):
        weight, _ = self.parameters
        if adds:
            of_weight = nn.grad.conv2d_weight(self.x, weight.shape, g, self.stride, 1)
            self.gradients[0] += of_weight
            self.gradients[1] += g.sum((0, 2, 3))
        return nn.grad.conv2d_input(self.x.shape, weight, g, self.stride, 1)


class BatchNorm:
    """Keeps mean and spread; its gain is that of the moment."""

    def __init__(self, weight, bias):
        self.parameters = [weight, bias]
        self.gradients = [torch.zeros_like(p) for p in self.parameters]

    def forward(self, x):
        gain, offset = (p[None, :, None, None] for p in self.parameters)
        centred = x - x.mean((0, 2, 3), keepdim=True)
        self.spread = torch.sqrt((centred**2).mean((0, 2, 3), keepdim=True) + 1e-5)
        self.unit = centred / self.spread
        return self.unit * gain + offset

    def backward(self, g, *, adds):
        if adds:
            self.gradients[0] += (g * self.unit).sum((0, 2, 3))
            self.gradients[1] += g.sum((0, 2, 3))
        g = g * self.parameters[0][None, :, None, None]
        along = (g * self.unit).mean((0, 2, 3), keepdim=True)
        return (g - g.mean((0, 2, 3), keepdim=True) - self.unit * along) / self.spread


class Leaky:
    parameters, gradients = (), ()

    def forward(self, x):
        self.slope = torch.where(x > 0, 1.0, 0.2).to(x)
        return x * self.slope

    def backward(self, g, *, adds):
        return g * self.slope


class Sigmoid:
    parameters, gradients = (), ()

    def forward(self, x):
        self.out = 1 / (1 + torch.exp(-x))
        return self.out

    def backward(self, g, *, adds):
        return g * self.out * (1 - self.out)


def discriminator(weights, n_layers):
    """Layers of a `PatchGAN` of these weights, in the order in which it applies them."""
    weights = iter(weights)
    layers = [Convolution(next(weights), next(weights), 2), Leaky()]
    for k in range(1, n_layers + 1):
        stride = 2 if k < n_layers else 1
        layers.append(Convolution(next(weights), next(weights), stride))
        layers += [BatchNorm(next(weights), next(weights)), Leaky()]
    return [*layers, Convolution(next(weights), next(weights), 1), Sigmoid()]


class Adam:
    def __init__(self, parameters, lr):
        self.parameters, self.lr, self.t = parameters, lr, 0
        self.m = [torch.zeros_like(p) for p in parameters]
        self.v = [torch.zeros_like(p) for p in parameters]

    def step(self, gradients, beta1=0.5, beta2=0.999):
        self.t += 1
        rate = self.lr * math.sqrt(1 - beta2**self.t) / (1 - beta1**self.t)
        for p, g, m, v in zip(self.parameters, gradients, self.m, self.v, strict=True):
            m.mul_(beta1).add_((1 - beta1) * g)
            v.mul_(beta2).add_((1 - beta2) * g * g)
            with torch.no_grad():
                p -= rate * m / (v.sqrt() + 1e-8)


def criterion(output, label):
    """Cross-entropy with what keeps logarithms finite, and its gradient."""
    eps = 1e-12
    loss = -(label * torch.log(output + eps) + (1 - label) * torch.log(1 - output + eps)).mean()
    gradient = -(label - output) / ((1 - output + eps) * (output + eps)) / output.numel()
    return loss.item(), gradient


def train(net_g, net_d, items, *, lr, l1_weight):
    """Take a step for each item (mask, image, dropped); losses of D on either, of G, and L1."""
    of_g = list(net_g.parameters())
    adam_g = Adam(of_g, lr)
    adam_d = Adam([p for layer in net_d for p in layer.parameters], lr)

    def run(x):
        for layer in net_d:
            x = layer.forward(x)
        return x

    def back(g, *, adds):
        for layer in reversed(net_d):
            g = layer.backward(g, adds=adds)
        return g

    def zero_biases():
        for layer in net_d:
            if isinstance(layer, Convolution):
                layer.parameters[1].zero_()
        for name, module in net_g.named_children():
            if "norm" not in name:
                module.bias.data.zero_()

    losses = []
    for mask, image, dropped in items:
        fake = net_g(mask, dropped)
        zero_biases()
        for layer in net_d:
            for gradient in layer.gradients:
                gradient.zero_()
        on_real, g = criterion(run(torch.cat([mask, image], 1)), 1.0)
        back(g, adds=True)
        output = run(torch.cat([mask, fake.detach()], 1))
        on_fake, g = criterion(output, 0.0)
        back(g, adds=True)
        adam_d.step([g for layer in net_d for g in layer.gradients])
        # The output is that of before the update, what the gradient passes that of after.
        zero_biases()
        of_generator, g = criterion(output, 1.0)
        to_image = back(g, adds=False)[:, 1:]
        apart = fake.detach() - image
        to_image = to_image + l1_weight * torch.sign(apart) / apart.numel()
        adam_g.step(torch.autograd.grad(fake, of_g, to_image))
        losses.append([on_real, on_fake, of_generator, apart.abs().mean().item()])
    return losses


def scale_line(line, n):
    """`image.scale` of one line of pixels."""
    m = len(line)
    if n > m:
        at = [k * (m - 1) / (n - 1) for k in range(n - 1)]
        inner = [line[int(x)] * (1 - x % 1) + line[int(x) + 1] * (x % 1) for x in at]
        return [*inner, line[-1]]
    if n == m:
        return list(line)
    means = []
    for k in range(n):
        first, last = k * m / n, (k + 1) * m / n
        covered = range(int(first), min(m, math.ceil(last)))
        shares = [min(last, j + 1) - max(first, j) for j in covered]
        total = sum(share * line[j] for share, j in zip(shares, covered, strict=True))
        means.append(total / sum(shares))
    return means


def scale(picture, height, width):
    rows = np.array([scale_line(row, width) for row in picture])
    return np.array([scale_line(column, height) for column in rows.T]).T


def jitter(picture, load, fine, corner, mirrored):
    """Scaled to `load`, cut to `fine` from a corner, mirrored; 0 to 1 becomes -1 to 1."""
    whole = scale(picture, *load) * 2 - 1
    cut = whole[corner[0] : corner[0] + fine[0], corner[1] : corner[1] + fine[1]]
    return cut[:, ::-1].copy() if mirrored else cut
