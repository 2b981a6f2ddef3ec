"""Training of the conditional GAN, resumable to the byte, and rendering by a trained generator."""

from functools import lru_cache

import torch

from snowsim.cgan import measured, pix2pix
from snowsim.cgan.networks import LOSSES, initialise
from snowsim.limits import check_count
from snowsim.patches import draw_index, from_signed
from snowsim.seeding import random_stream
from snowsim.training import (
    Resumable,
    Step,
    capturable_optimiser,
    is_gpu,
    load_weights,
    run_steps,
    set_rate,
)

RECIPES = {"measured": measured, "pix2pix": pix2pix}  # modules, by `Settings.method`
N_SCENES_HELD = 2500  # scenes kept in memory with what is prepared, each about 1 MB


class Training(Resumable):
    """Both networks, `generator` and `discriminator`, their optimisers and the steps taken, `step`.

    A training resumes from these and `seed`: what a step draws depends on seed and step alone.
    """

    def __init__(self, settings, *, seed, device="cpu"):
        self.generator, self.discriminator = networks_of(settings)
        networks = {"generator": self.generator, "discriminator": self.discriminator}
        for name, network in networks.items():
            initialise(network, rng=random_stream(seed, "cgan", name))
        super().__init__("cGAN", settings, seed, device, networks)
        rate = settings.learning_rate
        for name, network in networks.items():
            weights = network.parameters()
            # The betas of pix2pix.
            adam = capturable_optimiser(torch.optim.Adam, weights, rate, device, betas=(0.5, 0.999))
            self.optimisers[f"{name}_adam"] = adam


def networks_of(settings):
    """Generator and discriminator of some `Settings`, not initialised."""
    return RECIPES[settings.method].networks(settings)


def least_bytes(settings):
    """Least memory for weights, gradients and moments of both networks, without activations."""
    with torch.device("meta"):
        networks = networks_of(settings)
    n_weights = sum(weight.numel() for network in networks for weight in network.parameters())
    # Of a weight itself, its gradient and two moments, in float32.
    return 4 * 4 * n_weights


def train_steps(training, scenes, *, n_workers=0):
    """Train from where `training` is to its last step; yields steps taken and losses of each.

    A step shows one scene, drawn without replacement until all were seen, and updates the
    discriminator, then the generator. Losses are those of `snowsim.cgan.networks.update`; `l1` is a
    share of half the grey range. On a GPU they are given every 50 steps, means of these.
    `n_workers` processes prepare inputs ahead; results do not depend on it. ValueError without
    scenes or for one not trainable; FloatingPointError if a loss is not finite.
    """
    check_count("scenes to train on", len(scenes))
    settings = training.settings
    recipe = RECIPES[settings.method]

    @lru_cache(maxsize=N_SCENES_HELD)
    def held(number):
        return recipe.prepared(scenes[number], settings)

    if n_workers:
        # Read before the processes start, which then share them.
        for number in range(min(len(scenes), N_SCENES_HELD)):
            held(number)

    def batch_at(step):
        number = draw_index(len(scenes), step, training.seed, "cgan", "scenes")
        rng = random_stream(training.seed, "cgan", "step", step)
        return recipe.draw_batch(training.generator, held(number), settings, rng=rng)

    def update_both(batch):
        for optimiser in optimisers:
            optimiser.zero_grad(set_to_none=not is_gpu(training.device))
        losses = recipe.take_step(training, batch)
        return torch.stack([losses[name] for name in LOSSES]).detach()

    optimisers = list(training.optimisers.values())
    step = Step(update_both, optimisers, training.device)

    def take(batch):
        rate = recipe.learning_rate(settings, training.step)
        for optimiser in optimisers:
            for group in optimiser.param_groups:
                set_rate(group, rate)
        return step(batch)

    yield from run_steps(training, batch_at, take, LOSSES, n_workers=n_workers)


def render(generator, scene, settings, *, rng):
    """Echogram of the layers of a `Scene`, uint8, (range_bin, range_line), of any size.

    Renders a whole scene at once; pix2pix renders it resized to its crops of training. The result
    does not depend on which other scenes are rendered, in what order or by how many processes.

    Parameters
    ----------
    generator : torch.nn.Module
        A generator of `trained_generator`.
    scene : Scene
        Its echoes give the levels of layers and snow; `pix2pix` needs none. ValueError if its mask
        holds no layer, or if it lacks echoes that are needed.
    settings : Settings
        Those it was trained with. FloatingPointError if a pixel is not finite.
    rng : numpy.random.Generator
        All noise is drawn from it.
    """
    mask = scene.mask()
    if not mask.any():
        msg = (
            f"scene {scene.name}: mask without layers, "
            f"expected at least one annotated pixel in {mask.shape}"
        )
        raise ValueError(msg)
    generator.eval()
    image = RECIPES[settings.method].render_image(generator, scene, settings, rng=rng)
    if not torch.isfinite(image).all():
        msg = "generator renders values that are not finite: its training diverged"
        raise FloatingPointError(msg)
    return from_signed(image.clamp(-1, 1)[None, None])[0]


def trained_generator(weights, settings, *, device="cpu"):
    """Generator for `render`, of weights (dict of arrays) and the `Settings` of their training."""
    generator, _ = networks_of(settings)
    generator = load_weights(generator, weights, "generator")
    return generator.to(device=device, memory_format=torch.channels_last).eval()
