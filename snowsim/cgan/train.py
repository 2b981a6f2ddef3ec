"""Training of the conditional GAN: pix2pix with its settings, resumable to the byte."""

from functools import lru_cache

import torch
from torch.nn import functional

from snowsim.cgan.networks import PatchDiscriminator, UNetGenerator, initialise
from snowsim.patches import draw_index, draw_patches, to_signed
from snowsim.seeding import random_stream
from snowsim.training import load_weights, on_cpu

N_SCENES_HELD = 256  # scenes kept in memory, about 50 MB
N_STATISTICS_CROPS = 64


class Training:
    """Both networks, their optimisers and the number of steps taken.

    What a step draws depends on the seed and the step alone, so these and `seed` are all there is to resume from.

    Parameters
    ----------
    settings : Settings
    seed : int
    device : str
        Where to train, `cpu` or `cuda`.

    Attributes
    ----------
    generator, discriminator : torch.nn.Module
    step : int
        Steps taken.
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
        self._optimisers = {
            "generator_adam": _adam(self.generator, settings),
            "discriminator_adam": _adam(self.discriminator, settings),
        }

    def state(self):
        """Everything that a step changes but `step`, as nested dicts of CPU tensors, to be given to `restore`."""
        networks = {"generator": self.generator.state_dict(), "discriminator": self.discriminator.state_dict()}
        moments = {name: optimiser.state_dict()["state"] for name, optimiser in self._optimisers.items()}
        return on_cpu(networks | moments)

    def restore(self, state, step):
        """Take over a `state`, read back as nested dicts of arrays, and the number of steps it had taken.

        Raises
        ------
        ValueError
            If the state is not one of a training with these settings.
        """
        load_weights(self.generator, state.get("generator", {}), "generator")
        load_weights(self.discriminator, state.get("discriminator", {}), "discriminator")
        for name, optimiser in self._optimisers.items():
            _restore_adam(optimiser, state.get(name, {}), name)
        self.step = step


def least_bytes(settings):
    """Memory that weights, gradients and moments of both networks take at least, images and activations left out."""
    with torch.device("meta"):
        networks = UNetGenerator(settings.width, settings.depth), PatchDiscriminator(settings.width, settings.n_strided)
    return 4 * 4 * sum(parameter.numel() for network in networks for parameter in network.parameters())


def train_steps(training, scenes):
    """Train from where `training` is to its last step, one step at a time.

    Each step updates the discriminator, then the generator, on random crops of scenes, drawn without replacement until
    all were seen, flipped left to right half of the time.

    Parameters
    ----------
    training : Training
        Changed in place; between two steps its `state` may be saved.
    scenes : sequence of Scene
        With images; indexed when needed.

    Yields
    ------
    step : int
        Steps taken, counted from 1.
    losses : dict of float
        `discriminator_real`, `discriminator_fake` and `generator_adversarial` (0.69 is undecided with `bce`, 0.25 with
        `lsgan`) and `l1`, the mean absolute error as a share of half the grey range.

    Raises
    ------
    ValueError
        If there is no scene, or a scene drawn has no image, no contrast or no layer.
    FloatingPointError
        If a loss is not finite.

    Notes
    -----
    ``L_D = (A(D(x, y), 1) + A(D(x, G(x, z)), 0)) / 2``, ``L_G = A(D(x, G(x, z)), 1) + w mean |y - G(x, z)|`` with the
    adversarial loss A a cross-entropy or a square: Isola et al. (2017), eq. (7) of Yari et al. (2021).
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

    To be called before rendering and before the weights are saved; takes no part in the training itself.

    Parameters
    ----------
    training : Training
    scenes : sequence of Scene

    Notes
    -----
    Plain averages over fresh crops with the weights as they are. Exponential averages kept while the weights still move
    fast lag behind them: Wu & Johnson (2021), arXiv:2105.07576.
    """
    settings, generator = training.settings, training.generator
    for norm in generator.norms():
        norm.reset_running_stats()
    generator.train()
    arithmetic = torch.autocast(
        torch.device(training.device).type, torch.bfloat16, enabled=settings.precision == "bfloat16"
    )
    for number in range(N_STATISTICS_CROPS):
        scene = scenes[draw_index(len(scenes), number, training.seed, "cgan", "statistics")]
        rng = random_stream(training.seed, "cgan", "statistics", number)
        _, masks = draw_patches([scene], settings.n_range_bins, settings.n_range_lines, rng=rng)
        noise = generator.draw_noise(*masks.shape, dropout=settings.dropout, rng=rng)
        with torch.no_grad(), arithmetic:
            generator(to_signed(masks).to(training.device), noise)
    generator.eval()


def _step(training, mask, image, rng):
    """Update both networks on one batch; the losses before the update."""
    settings, generator, discriminator = training.settings, training.generator, training.discriminator
    for optimiser in training._optimisers.values():
        for group in optimiser.param_groups:
            group["lr"] = learning_rate(settings, training.step)
        optimiser.zero_grad(set_to_none=True)
    arithmetic = torch.autocast(mask.device.type, torch.bfloat16, enabled=settings.precision == "bfloat16")
    noise = generator.draw_noise(*mask.shape[::2], mask.shape[3], dropout=settings.dropout, rng=rng)
    with arithmetic:
        rendered = generator(mask, noise, own_statistics=True)
        real, fake = discriminator(mask, image), discriminator(mask, rendered.detach())
    real_loss, fake_loss = _adversarial(real, 1.0, settings), _adversarial(fake, 0.0, settings)
    (0.5 * (real_loss + fake_loss)).backward()
    training._optimisers["discriminator_adam"].step()
    discriminator.requires_grad_(False)
    with arithmetic:
        judged = discriminator(mask, rendered)
    adversarial, l1 = _adversarial(judged, 1.0, settings), functional.l1_loss(rendered.float(), image)
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


def _restore_adam(optimiser, state, name):
    """Fill in the moments, laid out in memory as the weights are; none are there before the first step."""
    parameters = [parameter for group in optimiser.param_groups for parameter in group["params"]]
    if len(state) not in (0, len(parameters)):
        msg = f"{name}: expected moments of {len(parameters)} weights, got {len(state)}: other settings made it"
        raise ValueError(msg)
    for index, values in state.items():
        parameter = parameters[int(index)]
        optimiser.state[parameter] = {
            key: (torch.empty_like(parameter) if value.ndim else torch.empty((), device=parameter.device)).copy_(
                torch.as_tensor(value)
            )
            for key, value in values.items()
        }
