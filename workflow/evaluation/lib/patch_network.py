"""A small network that tells patches of two kinds apart, to the bit the same for a seed."""

import math

import numpy as np
import torch
from torch import nn

from snowsim.patches import to_signed

WIDTH = 8
BATCH_SIZE = 64
LEARNING_RATE = 1e-2
WEIGHT_DECAY = 1e-2


def patch_network():
    """Three strided convolutions with batch normalisation, a mean over the patch, one logit."""
    layers = []
    n_in = 1
    for n_out, size in ((WIDTH, 5), (2 * WIDTH, 3), (4 * WIDTH, 3)):
        layers.append(nn.Conv2d(n_in, n_out, size, stride=2, padding=size // 2, bias=False))
        layers.append(nn.BatchNorm2d(n_out))
        layers.append(nn.ReLU())
        n_in = n_out
    return nn.Sequential(*layers, nn.AdaptiveAvgPool2d(1), nn.Flatten(), nn.Linear(n_in, 1))


def fit_network(patches, truth, *, n_steps, rng):
    """Train on patches of uint8 (patch, range_bin, range_line) and truth of bool.

    Gives a function from patches to decisions. AdamW with a one-cycle rate, patches in random
    order, flipped left to right half of the time.
    """
    torch.set_num_threads(1)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(int(rng.integers(2**31)))
        network = patch_network().to(memory_format=torch.channels_last)
    optimiser = torch.optim.AdamW(
        network.parameters(), lr=LEARNING_RATE, weight_decay=WEIGHT_DECAY, fused=True
    )
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, LEARNING_RATE, total_steps=n_steps)
    n_epochs = math.ceil(n_steps * BATCH_SIZE / len(truth))
    order = np.concatenate([rng.permutation(len(truth)) for _ in range(n_epochs)])
    network.train()
    for step in range(n_steps):
        chosen = order[step * BATCH_SIZE : (step + 1) * BATCH_SIZE]
        batch = to_signed(patches[chosen][:, :, :: rng.choice((1, -1))])
        logits = network(batch.contiguous(memory_format=torch.channels_last))[:, 0]
        target = torch.from_numpy(truth[chosen]).float()
        loss = nn.functional.binary_cross_entropy_with_logits(logits, target)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()
    network.eval()

    @torch.no_grad()
    def decide(of):
        return network(to_signed(of))[:, 0].numpy() > 0

    return decide
