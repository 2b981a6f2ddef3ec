"""Training of the conditional GAN: pix2pix with its settings, resumable to the byte."""

from functools import lru_cache

import torch
from torch.nn import functional

from snowsim.cgan.networks import PatchDiscriminator, UNetGenerator, initialise
from snowsim.patches import draw_index, draw_patches, to_signed
from snowsim.seeding import random_stream
from snowsim.training import arithmetic, load_moments, load_weights, moments_of, on_cpu

N_SCENES_HELD = 256  # scenes kept in memory, about 50 MB
N_STATISTICS_CROPS = 64


class Training:
    """Both networks, `generator` and `discriminator`, their optimisers and the number of steps taken, `step`.

    What a step draws depends on the seed and the step alone, so these and `seed` are all there is to resume from.
    """

    def __init__(self, settings, *, seed, device="cpu"):
        self.settings, self.seed, self.device = settings, seed, device
        self.step = 0
        self.generator = UNetGenerator(settings.width, settings.depth)
        self.discriminator = PatchDiscriminator(settings.width, settings.n_strided)
        initialise(self.generator, rng=random_stream(seed, "cgan", "generator"))
        initialise(self.discriminator, rng=random_stream(seed, "cgan", "discriminator"))
        for network in (self.generator, self.discriminator):
            network.to(device=device, memory_format=torch.channels_last)
        networks = {"generator_adam": self.generator, "discriminator_adam": self.discriminator}
        self._optimisers = {name: _adam(network, settings) for name, network in networks.items()}

    def state(self):
        """Everything that a step changes but `step`, as nested dicts of CPU tensors, to be given to `restore`."""
        networks = {"generator": self.generator.state_dict(), "discriminator": self.discriminator.state_dict()}
        moments = {name: moments_of(optimiser) for name, optimiser in self._optimisers.items()}
        return on_cpu(networks | moments)

    def restore(self, state, step):
        """Take over a `state`, read back as arrays, after `step` steps; ValueError if other settings made it."""
        load_weights(self.generator, state.get("generator", {}), "generator")
        load_weights(self.discriminator, state.get("discriminator", {}), "discriminator")
        for name, optimiser in self._optimisers.items():
            load_moments(optimiser, state.get(name, {}), name)
        self.step = step


def least_bytes(settings):
    """Least memory for weights, gradients and moments of both networks, without images and activations."""
    with torch.device("meta"):
        networks = UNetGenerator(settings.width, settings.depth), PatchDiscriminator(settings.width, settings.n_strided)
    return 4 * 4 * sum(parameter.numel() for network in networks for parameter in network.parameters())


def train_steps(training, scenes):
    """Train from where `training` is to its last step; yields the steps taken and the losses (dict) of each.

    A step updates the discriminator, then the generator, on random crops of scenes, drawn without replacement until all
    were seen, flipped left to right half of the time. Losses: ``L_D = (A(D(x, y), 1) + A(D(x, G(x, z)), 0)) / 2``,
    ``L_G = A(D(x, G(x, z)), 1) + w mean |y - G(x, z)|``, the adversarial A a cross-entropy (0.69 is undecided) or a
    square (0.25): Isola et al. (2017), eq. (7) of Yari et al. (2021); `l1` is a share of half the grey range.
    ValueError without scenes or for one not trainable; FloatingPointError if a loss is not finite.
    """
    if len(scenes) == 0:
        msg = "training needs at least one scene, got none"
        raise ValueError(msg)
    held = lru_cache(maxsize=N_SCENES_HELD)(scenes.__getitem__)
    settings = training.settings
    while training.step < settings.n_steps:
        drawn = range(training.step * settings.batch_size, (training.step + 1) * settings.batch_size)
        batch = [held(draw_index(len(scenes), position, training.seed, "cgan", "scenes")) for position in drawn]
        rng = random_stream(training.seed, "cgan", "step", training.step)
        images, masks = draw_patches(batch, settings.n_range_bins, settings.n_range_lines, rng=rng)
        losses = _step(training, to_signed(masks).to(training.device), to_signed(images).to(training.device), rng)
        training.step += 1
        if not torch.isfinite(torch.tensor(list(losses.values()))).all():
            msg = f"training diverged at step {training.step}: {losses}"
            raise FloatingPointError(msg)
        yield training.step, losses


def settle_statistics(training, scenes):
    """Set the normalisation statistics that the generator renders with, from crops of its training scenes.

    Plain averages over fresh crops with the weights as they are, before rendering and saving; no part of the training.
    Exponential averages lag behind weights that move fast: Wu & Johnson (2021), arXiv:2105.07576.
    """
    settings, generator = training.settings, training.generator
    for norm in generator.norms():
        norm.reset_running_stats()
    generator.train()
    for number in range(N_STATISTICS_CROPS):
        scene = scenes[draw_index(len(scenes), number, training.seed, "cgan", "statistics")]
        rng = random_stream(training.seed, "cgan", "statistics", number)
        _, masks = draw_patches([scene], settings.n_range_bins, settings.n_range_lines, rng=rng)
        noise = generator.draw_noise(*masks.shape, dropout=settings.dropout, rng=rng)
        with torch.no_grad(), arithmetic(training.device, settings.precision):
            generator(to_signed(masks).to(training.device), noise)
    generator.eval()


def _step(training, mask, image, rng):
    """Update both networks on one batch; the losses before the update."""
    settings, generator, discriminator = training.settings, training.generator, training.discriminator
    for optimiser in training._optimisers.values():
        for group in optimiser.param_groups:
            group["lr"] = learning_rate(settings, training.step)
        optimiser.zero_grad(set_to_none=True)
    noise = generator.draw_noise(*mask.shape[::2], mask.shape[3], dropout=settings.dropout, rng=rng)
    with arithmetic(training.device, settings.precision):
        rendered = generator(mask, noise, own_statistics=True)
        real, fake = discriminator(mask, image), discriminator(mask, rendered.detach())
    real_loss, fake_loss = _adversarial(real, 1.0, settings), _adversarial(fake, 0.0, settings)
    (0.5 * (real_loss + fake_loss)).backward()
    training._optimisers["discriminator_adam"].step()
    discriminator.requires_grad_(False)
    with arithmetic(training.device, settings.precision):
        decision = discriminator(mask, rendered)
    adversarial, l1 = _adversarial(decision, 1.0, settings), functional.l1_loss(rendered.float(), image)
    (adversarial + settings.l1_weight * l1).backward()
    training._optimisers["generator_adam"].step()
    discriminator.requires_grad_(True)
    losses = torch.stack([real_loss, fake_loss, adversarial, l1]).tolist()
    return dict(zip(("discriminator_real", "discriminator_fake", "generator_adversarial", "l1"), losses, strict=True))


def learning_rate(settings, step):
    """Rate of the step after `step` others: constant for half of them, then linearly to zero."""
    half = settings.n_steps // 2
    return settings.learning_rate * min(1.0, (settings.n_steps - step) / (settings.n_steps - half))


def _adversarial(logits, target, settings):
    """Mean loss of a map of logits that should all say `target`."""
    targets = torch.full_like(logits, target, dtype=torch.float32)
    if settings.adversarial == "lsgan":
        return functional.mse_loss(logits.float(), targets)
    return functional.binary_cross_entropy_with_logits(logits.float(), targets)


def _adam(network, settings):
    betas = (settings.beta1, settings.beta2)
    return torch.optim.Adam(network.parameters(), lr=settings.learning_rate, betas=betas, fused=True)
