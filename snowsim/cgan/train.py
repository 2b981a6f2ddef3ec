"""Training of the conditional GAN, resumable to the byte."""

from functools import lru_cache

import numpy as np
import torch
from torch.nn import functional

from snowsim.cgan import pix2pix
from snowsim.cgan.inputs import N_CHANNELS, Batch, conditions, is_snow, place_map, slabs_of
from snowsim.cgan.networks import (
    PatchDiscriminator,
    UNetGenerator,
    adversarial_loss,
    initialise,
)
from snowsim.limits import check_count
from snowsim.patches import draw_index, draw_patches, to_signed
from snowsim.seeding import random_stream
from snowsim.training import arithmetic, load_moments, load_weights, moments_of, on_cpu

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
            self.optimisers[f"{name}_adam"] = _adam(network, settings)

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
    if settings.method == "pix2pix":
        generator = pix2pix.Pix2PixGenerator(settings.width, settings.depth)
        return generator, PatchDiscriminator(settings.width, settings.n_strided)
    generator = UNetGenerator(settings.width, settings.depth, N_CHANNELS)
    return generator, PatchDiscriminator(settings.width, settings.n_strided, N_CHANNELS)


def least_bytes(settings):
    """Least memory for weights, gradients and moments of both networks, without activations."""
    with torch.device("meta"):
        networks = networks_of(settings)
    n_weights = sum(weight.numel() for network in networks for weight in network.parameters())
    return ADAM_BYTES * n_weights


def train_steps(training, scenes):
    """Train from where `training` is to its last step; yields steps taken and losses of each.

    A step updates the discriminator, then the generator, on random crops of scenes, drawn without
    replacement until all were seen, flipped left to right half of the time; `pix2pix` resizes them
    before. Losses: ``L_D = (A(D(x, y), 1) + A(D(x, G(x, z)), 0)) / 2``, ``L_G = A(D(x, G(x, z)), 1)
    + w mean |y - G(x, z)|``, the adversarial A a cross-entropy (0.69 is undecided): Isola et al.
    (2017), eq. (7) of Yari et al. (2021); `l1` is a share of half the grey range. ValueError
    without scenes or for one not trainable; FloatingPointError if a loss is not finite.
    """
    check_count("scenes to train on", len(scenes))
    held = lru_cache(maxsize=N_SCENES_HELD)(scenes.__getitem__)
    while training.step < training.settings.n_steps:
        losses = _take_step(training, held, len(scenes))
        training.step += 1
        if not np.isfinite(list(losses.values())).all():
            msg = f"training diverged at step {training.step}: {losses}"
            raise FloatingPointError(msg)
        yield training.step, losses


def _take_step(training, scene_at, n_scenes):
    """Take the next step; its losses, numbers."""
    settings = training.settings
    rng = random_stream(training.seed, "cgan", "step", training.step)
    first = training.step * settings.batch_size
    scenes = []
    for position in range(first, first + settings.batch_size):
        number = draw_index(n_scenes, position, training.seed, "cgan", "scenes")
        scenes.append(scene_at(number))
    _begin_step(training)
    if settings.method == "pix2pix":
        batch = pix2pix.draw_batch(training.generator, scenes, settings, rng=rng)
        losses = pix2pix.update(training, batch.on(training.device))
    else:
        batch = _draw_batch(training.generator, scenes, settings, rng)
        losses = _update(training, batch.on(training.device))
    values = torch.stack(list(losses.values())).tolist()
    return dict(zip(losses, values, strict=True))


def _draw_batch(generator, scenes, settings, rng):
    """`Batch` of crops of some scenes."""
    size = (settings.n_range_bins, settings.n_range_lines)
    images, _, places = draw_patches(scenes, *size, known=place_map, rng=rng)
    # Half a grey level of dither: that observed images are whole numbers must not tell them from
    # rendered ones.
    dither = rng.random(images.shape, dtype=np.float32) - np.float32(0.5)
    image = to_signed(images) + torch.from_numpy(dither[:, None] / 127.5)
    inputs = conditions(places)
    noise = generator.draw_noise(slabs_of(places), dropout=settings.dropout, rng=rng)
    return Batch(inputs, image, noise)


def _update(training, batch):
    """Update both networks on one batch; the losses before the update."""
    settings = training.settings
    generator = training.generator
    with arithmetic(training.device, settings.precision):
        rendered = generator(batch.inputs, batch.noise)
    rendered = rendered.float()
    l1 = functional.l1_loss(rendered, batch.image)
    loss = settings.l1_weight * l1
    losses = {}
    # Of what the image lacks grain has the texture, not the pixels: the least error is an image
    # without any.
    lacking = (batch.image - rendered).detach()
    generator.grain.mismatch(lacking, is_snow(batch.inputs)).backward()
    if settings.adversarial != "none":
        rendered = rendered + generator.grain(batch.noise).detach()
        losses = _step_discriminator(training, batch, rendered.detach())
        training.discriminator.requires_grad_(False)
        _, decision = _decide(training, batch, rendered)
        losses["generator_adversarial"] = adversarial_loss(decision, 1.0)
        loss = losses["generator_adversarial"] + loss
    loss.backward()
    training.optimisers["generator_adam"].step()
    training.discriminator.requires_grad_(True)
    losses["l1"] = l1
    return losses


def _begin_step(training):
    """Set the rate of both optimisers, and forget the gradients of the last step."""
    rate = learning_rate(training.settings, training.step)
    for optimiser in training.optimisers.values():
        for group in optimiser.param_groups:
            group["lr"] = rate
        optimiser.zero_grad(set_to_none=True)


def _step_discriminator(training, batch, rendered):
    """Update the discriminator; its losses before."""
    real, fake = _decide(training, batch, rendered)
    on_real = adversarial_loss(real, 1.0)
    on_fake = adversarial_loss(fake, 0.0)
    (0.5 * (on_real + on_fake)).backward()
    training.optimisers["discriminator_adam"].step()
    return {"discriminator_real": on_real, "discriminator_fake": on_fake}


def _decide(training, batch, rendered):
    """Logits of observed and of rendered images."""
    discriminator = training.discriminator
    with arithmetic(training.device, training.settings.precision):
        # Normalised together: by themselves, renders of twice the contrast are the same to it.
        inputs = torch.cat([batch.inputs, batch.inputs])
        images = torch.cat([batch.image, rendered])
        return discriminator(inputs, images).chunk(2)


def learning_rate(settings, step):
    """Rate of the step after `step` others: constant for half of them, then linearly to zero.

    Of `pix2pix` constant throughout.
    """
    if settings.method == "pix2pix":
        return settings.learning_rate
    half = settings.n_steps // 2
    share_left = (settings.n_steps - step) / (settings.n_steps - half)
    return settings.learning_rate * min(1.0, share_left)


def _adam(network, settings):
    rate = settings.learning_rate
    return torch.optim.Adam(network.parameters(), lr=rate, betas=BETAS, fused=True)
