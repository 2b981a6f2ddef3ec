"""Training of the conditional GAN, resumable to the byte."""

from functools import lru_cache

import numpy as np
import torch

from snowsim.cgan import measured, pix2pix
from snowsim.cgan.networks import initialise
from snowsim.limits import check_count
from snowsim.patches import draw_index
from snowsim.seeding import random_stream
from snowsim.training import load_moments, load_weights, moments_of, on_cpu

RECIPES = {"measured": measured, "pix2pix": pix2pix}  # modules, by `Settings.method`
N_SCENES_HELD = 256  # scenes kept in memory, about 50 MB
BETAS = (0.5, 0.999)  # of Adam, pix2pix
ADAM_BYTES = 16  # of a weight: itself, its gradient and two moments, float32


class Training:
    """Both networks, `generator` and `discriminator`, their optimisers and the steps taken, `step`.

    What a step draws depends on the seed and the step alone, so these and `seed` are all there is
    to resume from.
    """

    def __init__(self, settings, *, seed, device="cpu"):
        self.settings = settings
        self.seed = seed
        self.device = device
        self.step = 0
        self.generator, self.discriminator = networks_of(settings)
        self.optimisers = {}
        for name, network in self._networks().items():
            initialise(network, rng=random_stream(seed, "cgan", name))
            network.to(device=device, memory_format=torch.channels_last)
            options = {"lr": settings.learning_rate, "betas": BETAS, "fused": True}
            self.optimisers[f"{name}_adam"] = torch.optim.Adam(network.parameters(), **options)

    def _networks(self):
        return {"generator": self.generator, "discriminator": self.discriminator}

    def state(self):
        """Everything that a step changes but `step`, nested dicts of CPU tensors for `restore`."""
        state = {name: network.state_dict() for name, network in self._networks().items()}
        for name, optimiser in self.optimisers.items():
            state[name] = moments_of(optimiser)
        return on_cpu(state)

    def restore(self, state, step):
        """Take over a `state`, read back as arrays, after `step` steps.

        ValueError if other settings made it.
        """
        for name, network in self._networks().items():
            load_weights(network, state.get(name, {}), name)
        for name, optimiser in self.optimisers.items():
            load_moments(optimiser, state.get(name, {}))
        self.step = step


def networks_of(settings):
    """Generator and discriminator of some `Settings`, not initialised."""
    return RECIPES[settings.method].networks(settings)


def least_bytes(settings):
    """Least memory for weights, gradients and moments of both networks, without activations."""
    with torch.device("meta"):
        networks = networks_of(settings)
    n_weights = sum(weight.numel() for network in networks for weight in network.parameters())
    return ADAM_BYTES * n_weights


def train_steps(training, scenes):
    """Train from where `training` is to its last step; yields steps taken and losses of each.

    A step shows one scene, drawn without replacement until all were seen, and updates the
    discriminator, then the generator. Losses are those of `snowsim.cgan.networks.update`; `l1` is a
    share of half the grey range. ValueError without scenes or for one not trainable;
    FloatingPointError if a loss is not finite.
    """
    check_count("scenes to train on", len(scenes))
    held = lru_cache(maxsize=N_SCENES_HELD)(scenes.__getitem__)
    while training.step < training.settings.n_steps:
        number = draw_index(len(scenes), training.step, training.seed, "cgan", "scenes")
        losses = _take_step(training, held(number))
        training.step += 1
        if not np.isfinite(list(losses.values())).all():
            msg = f"training diverged at step {training.step}: {losses}"
            raise FloatingPointError(msg)
        yield training.step, losses


def _take_step(training, scene):
    """Take the next step; its losses, numbers."""
    settings = training.settings
    recipe = RECIPES[settings.method]
    rate = recipe.learning_rate(settings, training.step)
    for optimiser in training.optimisers.values():
        for group in optimiser.param_groups:
            group["lr"] = rate
        optimiser.zero_grad(set_to_none=True)
    rng = random_stream(training.seed, "cgan", "step", training.step)
    batch = recipe.draw_batch(training.generator, scene, settings, rng=rng)
    losses = recipe.take_step(training, batch.on(training.device))
    values = torch.stack(list(losses.values())).tolist()
    return dict(zip(losses, values, strict=True))
