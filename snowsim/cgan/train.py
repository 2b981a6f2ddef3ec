"""Training of the conditional GAN: pix2pix with its settings, resumable to the byte."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import torch
from torch.nn import functional

from snowsim.cgan.guided import correction, guide_map
from snowsim.cgan.inputs import conditions, n_channels, place_map
from snowsim.cgan.networks import PatchDiscriminator, UNetGenerator, initialise
from snowsim.patches import draw_index, draw_patches, to_signed
from snowsim.seeding import random_stream
from snowsim.training import arithmetic, load_moments, load_weights, moments_of, on_cpu

N_SCENES_HELD = 256  # scenes kept in memory, about 50 MB
N_LAGS = 5  # [range bins] as many as grain has weights


class Training:
    """Both networks, `generator` and `discriminator`, their optimisers and the number of steps taken, `step`.

    What a step draws depends on the seed and the step alone, so these and `seed` are all there is
    to resume from.
    """

    def __init__(self, settings, *, seed, device="cpu"):
        self.settings, self.seed, self.device = settings, seed, device
        self.step = 0
        self.generator, self.discriminator = networks_of(settings)
        initialise(self.generator, rng=random_stream(seed, "cgan", "generator"))
        initialise(self.discriminator, rng=random_stream(seed, "cgan", "discriminator"))
        for network in (self.generator, self.discriminator):
            network.to(device=device, memory_format=torch.channels_last)
        networks = {"generator_adam": self.generator, "discriminator_adam": self.discriminator}
        self._optimisers = {name: _adam(network, settings) for name, network in networks.items()}

    def state(self):
        """Everything that a step changes but `step`, as nested dicts of CPU tensors, to be given to `restore`."""
        networks = {
            "generator": self.generator.state_dict(),
            "discriminator": self.discriminator.state_dict(),
        }
        moments = {name: moments_of(optimiser) for name, optimiser in self._optimisers.items()}
        return on_cpu(networks | moments)

    def restore(self, state, step):
        """Take over a `state`, read back as arrays, after `step` steps; ValueError if other settings made it."""
        load_weights(self.generator, state.get("generator", {}), "generator")
        load_weights(self.discriminator, state.get("discriminator", {}), "discriminator")
        for name, optimiser in self._optimisers.items():
            load_moments(optimiser, state.get(name, {}), name)
        self.step = step


def networks_of(settings):
    """Generator and discriminator of some `Settings`, not initialised."""
    n_told, n_inputs = n_channels(settings.method)
    how = {"statistics": settings.statistics, "is_noisy": settings.method != "pix2pix"}
    # Nothing but a discriminator teaches grain, and PHY's renders have their speckle.
    how["has_grain"] = settings.method == "depth" and settings.adversarial != "none"
    generator = UNetGenerator(settings.width, settings.depth, n_inputs, **how)
    return generator, PatchDiscriminator(settings.width, settings.n_strided, n_told)


def least_bytes(settings):
    """Least memory for weights, gradients and moments of both networks, without images and activations."""
    with torch.device("meta"):
        networks = networks_of(settings)
    return (
        4 * 4 * sum(parameter.numel() for network in networks for parameter in network.parameters())
    )


def train_steps(training, scenes, guides=None):
    """Train from where `training` is to its last step; yields the steps taken and the losses (dict) of each.

    A step updates the discriminator, then the generator, on random crops of scenes, drawn without
    replacement until all were seen, flipped left to right half of the time. Losses: ``L_D = (A(D(x,
    y), 1) + A(D(x, G(x, z)), 0)) / 2``, ``L_G = A(D(x, G(x, z)), 1) + w mean |y - G(x, z)|``, the
    adversarial A a cross-entropy (0.69 is undecided) or a square (0.25): Isola et al. (2017), eq.
    (7) of Yari et al. (2021); `l1` is a share of half the grey range. `guided` renders crops of
    `guides`, in place of y stands PHY's image of them, and the discriminator does not see the mask.
    ValueError without scenes or for one not trainable; FloatingPointError if a loss is not finite.
    """
    if len(scenes) == 0:
        msg = "training needs at least one scene, got none"
        raise ValueError(msg)
    held = lru_cache(maxsize=N_SCENES_HELD)(scenes.__getitem__)
    while training.step < training.settings.n_steps:
        rng = random_stream(training.seed, "cgan", "step", training.step)
        losses = _step(training, _draw_batch(training, held, len(scenes), guides, rng))
        training.step += 1
        if not torch.isfinite(torch.tensor(list(losses.values()))).all():
            msg = f"training diverged at step {training.step}: {losses}"
            raise FloatingPointError(msg)
        yield training.step, losses


@dataclass(frozen=True)
class Batch:
    """What a step is given, tensors (patch, channel, range_bin, range_line) in [-1, 1], but for noise, a dict of them.

    `given`: what the discriminator knows of observed and of rendered images; `base`: what a guided
    generator corrects.
    """

    inputs: torch.Tensor
    noise: dict
    given: tuple
    image: torch.Tensor
    target: torch.Tensor
    base: torch.Tensor | None = None


def _draw_batch(training, held, n_scenes, guides, rng):
    """`Batch` of the next step."""
    settings, device = training.settings, training.device
    positions = range(
        training.step * settings.batch_size, (training.step + 1) * settings.batch_size
    )

    def crops(get, n, of, known):
        drawn = [get(draw_index(n, position, training.seed, "cgan", of)) for position in positions]
        return draw_patches(
            drawn, settings.n_range_bins, settings.n_range_lines, known=known, rng=rng
        )

    images, masks, places = crops(held, n_scenes, "scenes", place_map)
    # Half a grey level of dither: that observed images are whole numbers must not tell them from
    # rendered ones.
    dither = (rng.random(images.shape, dtype=np.float32) - np.float32(0.5))[:, None] / 127.5
    image = (to_signed(images) + torch.from_numpy(dither)).to(device)
    given = conditions(settings.method, masks & (settings.method != "guided"), places).to(device)
    if settings.method != "guided":
        noise = training.generator.draw_noise(places[..., 1], dropout=settings.dropout, rng=rng)
        return Batch(given, noise, (given, given), image, image)
    _, masks, maps = crops(guides.__getitem__, len(guides), "guides", guide_map)
    slabs, _, mean, speckle = np.moveaxis(maps[..., 1:], 3, 0)
    noise = training.generator.draw_noise(slabs.astype(int), dropout=settings.dropout, rng=rng)
    base, mean = (
        torch.from_numpy(values)[:, None].to(device) for values in (mean + speckle, mean.copy())
    )
    inputs = torch.cat([conditions("guided", masks, maps).to(device), mean], dim=1)
    return Batch(
        inputs,
        noise,
        (given, conditions("guided", masks & False, maps).to(device)),
        image,
        base,
        base,
    )


def _step(training, batch):
    """Update both networks on one batch; the losses before the update."""
    settings, generator, discriminator = (
        training.settings,
        training.generator,
        training.discriminator,
    )
    for optimiser in training._optimisers.values():
        for group in optimiser.param_groups:
            group["lr"] = learning_rate(settings, training.step)
        optimiser.zero_grad(set_to_none=True)
    with arithmetic(training.device, settings.precision):
        rendered = generator(batch.inputs, batch.noise)
        grain = generator.grain(batch.noise, *rendered.shape[2:])
    rendered = rendered.float() if batch.base is None else batch.base + correction(rendered)
    l1 = functional.l1_loss(rendered, batch.target)
    losses = {}
    if generator.has_grain:
        # Of what the image lacks grain has the texture, not the pixels: the least error is an image
        # without any.
        lacking = autocovariance((batch.target - rendered).detach())
        ((autocovariance(grain.float()) - lacking) ** 2).sum().backward()
        rendered = rendered + grain.detach()
    if settings.adversarial != "none":
        real, fake = _decide(training, batch, rendered.detach())
        losses["discriminator_real"] = _adversarial(real, 1.0, settings)
        losses["discriminator_fake"] = _adversarial(fake, 0.0, settings)
        (0.5 * sum(losses.values())).backward()
        training._optimisers["discriminator_adam"].step()
        discriminator.requires_grad_(False)
        _, decision = _decide(training, batch, rendered)
        losses["generator_adversarial"] = _adversarial(decision, 1.0, settings)
    (losses.get("generator_adversarial", 0.0) + settings.l1_weight * l1).backward()
    training._optimisers["generator_adam"].step()
    discriminator.requires_grad_(True)
    losses["l1"] = l1
    return dict(zip(losses, torch.stack(list(losses.values())).tolist(), strict=True))


def autocovariance(images):
    """Down range, at lags of 0 to `N_LAGS` - 1 bins, of how neighbouring range lines differ: speckle, not layers.

    Last, that of their means, as many times as there are lags: the gain of a line as a whole.
    """
    change = images[..., 1:] - images[..., :-1]
    height = change.shape[2]
    products = [
        (change[:, :, lag:] * change[:, :, : height - lag]).mean() / 2 for lag in range(N_LAGS)
    ]
    return torch.stack([*products, N_LAGS * (change.mean(dim=2) ** 2).mean() / 2])


def _decide(training, batch, rendered):
    """Logits of observed and of rendered images."""
    discriminator, precision = training.discriminator, training.settings.precision
    with arithmetic(training.device, precision):
        if training.settings.method == "pix2pix":
            return discriminator(batch.given[0], batch.image), discriminator(
                batch.given[1], rendered
            )
        # Normalised together: by themselves, renders of twice the contrast are the same to it.
        return discriminator(torch.cat(batch.given), torch.cat([batch.image, rendered])).chunk(2)


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
    return torch.optim.Adam(
        network.parameters(), lr=settings.learning_rate, betas=betas, fused=True
    )
