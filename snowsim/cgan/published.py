"""pix2pix as published: networks, jitter of scenes, updates.

Isola, Zhu, Zhou & Efros (2017), CVPR, and its code in Torch, github.com/phillipi/pix2pix, before
March 2017, which normalises the innermost stage as the paper's experiments did.
"""

from functools import lru_cache

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from snowsim.cgan.inputs import Batch
from snowsim.cgan.networks import SLOPE, Norm, adversarial_loss, stage_channels
from snowsim.patches import check_trainable
from snowsim.training import arithmetic

ENLARGED = 286 / 256  # a scene is resized to this much more than the crop that is cut out of it
N_DROPPED_OUT = 3  # decoder stages that drop out, from the innermost on
EPSILON_ADAM = 1e-8


class PublishedGenerator(nn.Module):
    """U-Net from masks to images, (patch, 1, range_bin, range_line) in [-1, 1].

    Encoder channels ``width * (1, 2, 4, 8, 8, ...)``, `depth` halvings, of which sizes must be
    multiples; every convolution has a bias, every stage but the outermost two is normalised by the
    images at hand.
    """

    has_grain = False

    def __init__(self, width=64, depth=8):
        super().__init__()
        self.channels = stage_channels(width, depth)
        before = [1, *self.channels]
        self.down = nn.ModuleList(
            nn.Conv2d(n_in, n_out, 4, stride=2, padding=1)
            for n_in, n_out in zip(before, self.channels, strict=False)
        )
        self.norm_down = nn.ModuleList(Norm(n) for n in self.channels[1:])
        self.up = nn.ModuleList()
        for stage, n_out in enumerate(before[:-1]):
            is_innermost = stage == depth - 1
            n_in = self.channels[stage] * (1 if is_innermost else 2)
            self.up.append(nn.ConvTranspose2d(n_in, n_out, 4, stride=2, padding=1))
        self.norm_up = nn.ModuleList(Norm(n) for n in self.channels[:-1])

    def draw_noise(self, slabs, *, dropout=0.5, rng):
        """Dropout of one pass, 0 or 1 / (1 - dropout), by stage.

        Of `slabs` (patch, range_bin, range_line) the shape counts.
        """
        n_patches, n_range_bins, n_range_lines = slabs.shape
        innermost = len(self.channels) - 1
        noise = {}
        for stage in range(innermost, max(innermost - N_DROPPED_OUT, 0), -1):
            n_rows = n_range_bins >> stage
            n_columns = n_range_lines >> stage
            shape = (n_patches, self.channels[stage - 1], n_rows, n_columns)
            kept = rng.random(shape) >= dropout
            noise[stage] = _tensor(kept / (1 - dropout))
        return noise

    def forward(self, masks, noise):
        """Images of some masks, given the noise of `draw_noise`."""
        kept = [self.down[0](masks)]
        for halve, norm in zip(self.down[1:], self.norm_down, strict=True):
            rectified = functional.leaky_relu(kept[-1], SLOPE)
            kept.append(norm(halve(rectified), "scene"))
        x = kept.pop()
        for stage in range(len(kept), 0, -1):
            x = self.up[stage](functional.relu(x))
            x = self.norm_up[stage - 1](x, "scene")
            if stage in noise:
                x = x * noise[stage].to(x)
            # An encoder's features reach the decoder through both of its rectifiers.
            x = torch.cat([x, kept[stage - 1]], dim=1)
        return torch.tanh(self.up[0](functional.relu(x)))


@lru_cache(maxsize=64)
def resizing(n_from, n_to):
    """Weights (new pixel, pixel) by which Torch's `image.scale` resizes one side.

    Upwards linear between pixels, the ends kept; downwards the mean of what a new pixel covers.
    """
    if n_to > n_from:
        at = np.linspace(0, n_from - 1, n_to)[:, None]
        return np.maximum(1 - np.abs(at - np.arange(n_from)), 0)
    edges = np.arange(n_to + 1)[:, None] * (n_from / n_to)
    # How much of every pixel lies above each edge.
    above = np.clip(edges - np.arange(n_from), 0, 1)
    return np.diff(above, axis=0) * (n_to / n_from)


def resized(image, n_rows, n_columns):
    """An image (row, column) at another size, float64."""
    down = resizing(image.shape[0], n_rows)
    across = resizing(image.shape[1], n_columns)
    return down @ image @ across.T


def jittered(scene, settings, *, rng):
    """Mask and image of a scene in [-1, 1], resized to more than the crop, cut and mirrored.

    (2, range_bin, range_line). The first row and line are never in the crop, as published.
    """
    check_trainable(scene)
    sizes = (settings.n_range_bins, settings.n_range_lines)
    enlarged = [round(ENLARGED * size) for size in sizes]
    window = []
    for size, whole in zip(sizes, enlarged, strict=True):
        first = int(np.ceil(rng.uniform(0.01, whole - size)))
        window.append(slice(first, first + size))
    step = -1 if rng.random() > 0.5 else 1
    pair = [2.0 * scene.mask() - 1, scene.image / 127.5 - 1]
    return np.stack([resized(of, *enlarged)[tuple(window)][:, ::step] for of in pair])


def draw_batch(generator, scene_at, n_scenes, settings, *, rng):
    """`Batch` of scenes drawn with replacement."""
    pairs = []
    for _ in range(settings.batch_size):
        scene = scene_at(int(rng.integers(n_scenes)))
        pairs.append(jittered(scene, settings, rng=rng))
    inputs, image = _tensor(np.stack(pairs, axis=1))[:, :, None]
    noise = generator.draw_noise(inputs[:, 0], dropout=settings.dropout, rng=rng)
    return Batch(inputs, image, noise)


def update(training, batch):
    """Update both networks on one batch; the losses before.

    The generator's adversarial gradient passes the discriminator's new weights but the features of
    its old ones: the published code does not run the discriminator anew after its update. Biases of
    convolutions are zeroed before each update, so that the discriminator's never act and the
    generator's hold the last update alone.
    """
    settings = training.settings
    generator = training.generator
    discriminator = training.discriminator
    with arithmetic(training.device, settings.precision):
        rendered = generator(batch.inputs, batch.noise).to(batch.image)
        real = discriminator(batch.inputs, batch.image)
        fake = discriminator(batch.inputs, rendered)
    l1 = functional.l1_loss(rendered, batch.image)
    loss = settings.l1_weight * l1
    losses = {}
    if settings.adversarial != "none":
        losses["discriminator_real"] = adversarial_loss(real, 1.0)
        losses["discriminator_fake"] = adversarial_loss(fake, 0.0)
        # Not halved.
        total = losses["discriminator_real"] + losses["discriminator_fake"]
        weights = list(discriminator.parameters())
        total.backward(inputs=weights, retain_graph=True)
        losses["generator_adversarial"] = adversarial_loss(fake, 1.0)
        loss = losses["generator_adversarial"] + loss
        with torch.autograd._unsafe_preserve_version_counter(tuple(weights)):
            _step(training, "discriminator")
            _zero_biases(discriminator)
    loss.backward(inputs=list(generator.parameters()))
    _zero_biases(generator)
    _step(training, "generator")
    losses["l1"] = l1
    return losses


def _step(training, name):
    """Take Adam's step as Torch's optim does: its epsilon counts before bias is corrected."""
    optimiser = training.optimisers[f"{name}_adam"]
    beta2 = training.settings.beta2
    for group in optimiser.param_groups:
        group["eps"] = EPSILON_ADAM / np.sqrt(1 - beta2 ** (training.step + 1))
    optimiser.step()


@torch.no_grad()
def _zero_biases(network):
    for module in network.modules():
        if isinstance(module, (nn.Conv2d, nn.ConvTranspose2d)):
            module.bias.zero_()


def render_image(generator, scene, settings, *, rng):
    """Image of a scene's mask, float tensor (range_bin, range_line) in [-1, 1].

    The mask is resized to the size of the crops and the image back. Dropout stays on, and images
    are normalised by themselves, as published.
    """
    size = (settings.n_range_bins, settings.n_range_lines)
    mask = resized(2.0 * scene.mask() - 1, *size)
    inputs = _tensor(mask)[None, None]
    noise = generator.draw_noise(inputs[:, 0], dropout=settings.dropout, rng=rng)
    device = next(generator.parameters()).device
    with torch.inference_mode(), arithmetic(device, settings.precision):
        image = generator(inputs.to(device), noise)[0, 0].double().cpu().numpy()
    return torch.from_numpy(resized(image, scene.n_range_bins, scene.n_range_lines))


def _tensor(array):
    return torch.as_tensor(array, dtype=torch.get_default_dtype())
