"""Training of the tracker, by the published recipe or a modern one, resumable to the byte."""

import math

import numpy as np
import torch
from torch.nn import functional

from snowsim.constants import OUTPUTS
from snowsim.echogram import layer_mask
from snowsim.patches import draw_patches, whole_copy
from snowsim.seeding import random_stream
from snowsim.tracker.network import NETWORKS
from snowsim.tracker.sampling import copy_shown
from snowsim.training import arithmetic, load_moments, load_weights, moments_of, on_cpu

# So far a picked layer wanders along a gap; half the least first layer of the paper.
REACH_BINS = 8.0
WARM_UP = 0.1  # share of the steps in which `one_cycle` rises
# Published code: rate multipliers of the last stage, the sides and the fuse; biases have twice
# their weights' rate, and no decay, but for those of the last stage, where its key is misspelt.
PUBLISHED_MULTIPLIERS = {"stages.4": 100.0, "sides": 0.01, "fuse": 0.001}
DECAYING_BIASES = "stages.4"


def annotated_pixels(scene, layer_bins, n_range_bins, reach_bins=REACH_BINS):
    """Where the picks of a scene tell layers from background, bool (`n_range_bins`, range_line).

    Unknown is what lies within `reach_bins` of the continuation of a picked layer across its gaps
    (straight between picks, level beyond the first and the last), and all deeper than the deepest
    pick or continuation by more than that. A layer between two picked ones that has no pick at all
    goes unnoticed. `layer_bins` (layer, range_line) are the scene's, scaled or not; a scene without
    `complete_layer_bins` is known everywhere.
    """
    known = np.ones((n_range_bins, layer_bins.shape[1]), dtype=bool)
    if scene.complete_layer_bins is None:
        return known
    bins = np.arange(n_range_bins)[:, None]
    lines = np.arange(layer_bins.shape[1])
    deepest = np.full(lines.size, -np.inf)
    for layer in layer_bins:
        picked = np.isfinite(layer)
        if not picked.any():
            continue
        continued = np.interp(lines, lines[picked], layer[picked])
        known &= picked | (np.abs(bins - continued) > reach_bins)
        deepest = np.maximum(deepest, continued)
    known &= bins <= deepest + reach_bins
    # A pick is known even where it lies near the gap of another layer.
    return known | layer_mask(layer_bins, n_range_bins)


class Training:
    """The network, its optimiser and the number of gradients taken.

    What a step draws depends on the seed and the step alone, so these and `seed` are all there is
    to resume from.

    Parameters
    ----------
    settings : Settings
    seed : int
    device : str
        Where to train, `cpu` or `cuda`.

    Attributes
    ----------
    network : MultiScaleNetwork or PublishedNetwork
    step : int
        Gradients taken.
    """

    def __init__(self, settings, *, seed, device="cpu"):
        self.settings = settings
        self.seed = seed
        self.device = device
        self.step = 0
        self.network = NETWORKS[settings.network](settings.width)
        self.network.initialise(rng=random_stream(seed, "tracker", "network"))
        self.network.to(device=device, memory_format=torch.channels_last)
        self._optimiser = _optimiser(self.network, settings)

    def state(self):
        """All that a step changes but `step`, as nested dicts of CPU tensors, for `restore`."""
        gradients = {name: weights.grad for name, weights in self.network.named_parameters()}
        state = {
            "network": self.network.state_dict(),
            "optimiser": moments_of(self._optimiser),
            "gradient": {name: sums for name, sums in gradients.items() if sums is not None},
        }
        return on_cpu(state)

    def restore(self, state, step):
        """Take over a `state`, read back as arrays, after `step` steps.

        ValueError if other settings made it.
        """
        load_weights(self.network, state.get("network", {}), "tracker")
        load_moments(self._optimiser, state.get("optimiser", {}), "tracker")
        gradients = state.get("gradient", {})
        for name, parameter in self.network.named_parameters():
            if name in gradients:
                parameter.grad = torch.empty_like(parameter).copy_(torch.as_tensor(gradients[name]))
        self.step = step


def train_steps(training, scenes):
    """Train from where `training` is to its last step, one gradient at a time.

    Parameters
    ----------
    training : Training
        Changed in place; between two steps its `state` may be saved.
    scenes : TrainingSet
        Or anything else that gives the scene of each draw, `scenes[position]`, from 0 without end,
        and, for copies, `n_per_epoch`; ValueError if a scene has no image, no contrast or, but for
        copies, no layer.

    Yields
    ------
    step : int
        Gradients taken, counted from 1.
    losses : dict of float
        Class-balanced cross-entropy per pixel of each of `OUTPUTS`, and `total`; FloatingPointError
        if not finite.
    """
    settings = training.settings
    copies = settings.augmentation == "copies"
    n_per_epoch = settings.n_steps
    if copies:
        n_per_epoch = settings.n_copies * scenes.n_per_epoch
        _check_copies(settings, n_per_epoch)
    draw = _copy if copies else _patches
    while training.step < settings.n_steps:
        images, *maps = draw(training, scenes)
        maps = (torch.from_numpy(array).to(training.device) for array in maps)
        images = training.network.to_input(images).to(training.device)
        losses = _step(training, images, *maps, n_per_epoch=n_per_epoch)
        training.step += 1
        if not math.isfinite(losses["total"]):
            msg = f"training diverged at step {training.step}: loss {losses['total']}"
            raise FloatingPointError(msg)
        yield training.step, losses


def _check_copies(settings, n_per_epoch):
    """Refuse what copies cannot be.

    Cut, several a gradient, masked, or too few in an epoch for an update.
    """
    cut = settings.n_range_bins or settings.n_range_lines
    if settings.batch_size > 1 or cut or settings.mask_unannotated:
        msg = "augmentation copies: expected batch_size 1, no crop and mask_unannotated false"
        raise ValueError(msg)
    if n_per_epoch < settings.n_accumulated:
        update = f"an update of {settings.n_accumulated}"
        msg = f"an epoch of {n_per_epoch} gradients never fills {update}"
        raise ValueError(msg)


def _patches(training, scenes):
    """Crops of the next scenes, of one drawn scale; their masks and, if wanted, what is known."""
    settings = training.settings
    first = training.step * settings.batch_size
    rng = random_stream(training.seed, "tracker", "step", training.step)
    return draw_patches(
        [scenes[first + place] for place in range(settings.batch_size)],
        settings.n_range_bins,
        settings.n_range_lines,
        scale=settings.scales[rng.integers(len(settings.scales))],
        flip=settings.flip,
        known=annotated_pixels if settings.mask_unannotated else None,
        rng=rng,
    )


def _copy(training, scenes):
    """The next scene of an epoch of copies, whole, and its mask, as stacks of one."""
    settings = training.settings
    draw, copy = copy_shown(training.step, scenes.n_per_epoch, settings.n_copies, training.seed)
    mirrored = copy == len(settings.scales)
    scale = 1 if mirrored else settings.scales[copy]
    image, mask = whole_copy(scenes[draw], scale, mirrored)
    return image[None], mask[None]


def balanced_cross_entropy(logits, masks, known=None, *, loss="logits", layer_share=None):
    """Class-balanced cross-entropy of each output, summed over pixels, mean of images, (output,).

    `logits` (output, patch, 1, range_bin, range_line), `masks` and, optionally, `known` of bool
    (patch, range_bin, range_line): pixels that count. Layers weigh by the share of background,
    background by that of layers: Xie & Tu (2015), ICCV, eq. (2), by `layer_share` in every image,
    or if None by the image's own. ``-y log s(z) - (1 - y) log(1 - s(z)) = log(1 + exp((1 - 2 y)
    z))`` for y of 0 or 1; with `loss` of `sigmoids`, as the published code, s(z) is rounded to
    float32 first and logarithms are cut at -100.
    """
    layer = masks[:, None].float()
    counts = torch.ones_like(layer) if known is None else known[:, None].float()
    if layer_share is None:
        n_pixels = counts.sum(dim=(1, 2, 3), keepdim=True)
        layer_share = (layer * counts).sum(dim=(1, 2, 3), keepdim=True) / n_pixels
    weight = counts * torch.where(masks[:, None], 1 - layer_share, layer_share)
    if loss == "sigmoids":
        probability = torch.sigmoid(logits.float())
        truth = layer.expand_as(probability)
        cost = functional.binary_cross_entropy(probability, truth, reduction="none")
    else:
        cost = functional.softplus((1 - 2 * layer) * logits.float())
    # A product of matrices: nothing of the size of `logits` is made but the cost.
    return cost.flatten(1) @ weight.flatten() / masks.shape[0]


def rate_factor(settings, step):
    """Rate, of the highest, of the step after `step` others, or updates where these count."""
    if settings.schedule != "one_cycle":
        return 0.1 ** (step // settings.n_steps_per_tenth)
    done = (step + 1) / settings.n_steps
    if done < WARM_UP:
        return done / WARM_UP
    return 0.5 * (1 + math.cos(math.pi * (done - WARM_UP) / (1 - WARM_UP)))


def _step(training, images, masks, known=None, *, n_per_epoch):
    """Add one gradient and, when enough are there, change the weights; the losses before.

    Gradients are counted anew after every `n_per_epoch`; those that filled no update stay in the
    sum.
    """
    settings = training.settings
    with arithmetic(training.device, settings.precision):
        logits = training.network(images)
    per_output = balanced_cross_entropy(
        logits, masks, known, loss=settings.loss, layer_share=settings.layer_share
    )
    n_pixels = masks[0].numel()
    share = settings.n_accumulated * (n_pixels if settings.reduction == "mean" else 1)
    (per_output.sum() / share).backward()
    epoch, within = divmod(training.step, n_per_epoch)
    if (within + 1) % settings.n_accumulated == 0:
        n_updates_per_epoch = n_per_epoch // settings.n_accumulated
        n_updates = epoch * n_updates_per_epoch + within // settings.n_accumulated
        _update(training, n_updates if settings.schedule == "updates" else training.step)
    per_pixel = (per_output.detach() / n_pixels).tolist()
    losses = dict(zip(OUTPUTS, per_pixel, strict=True))
    return losses | {"total": sum(per_pixel)}


def _update(training, step):
    """Change the weights by the gradients summed, at the rate of this step of the schedule."""
    optimiser = training._optimiser
    factor = rate_factor(training.settings, step)
    for group in optimiser.param_groups:
        group["lr"] = group["highest"] * factor
    optimiser.step()
    optimiser.zero_grad(set_to_none=True)


def _optimiser(network, settings):
    """Optimiser with one group per rate and decay.

    A call a group costs more than the step of a small network.
    """
    groups = {}
    for name, parameter in network.named_parameters():
        rate = settings.learning_rate
        decay = settings.weight_decay
        if settings.published_multipliers:
            for part, factor in PUBLISHED_MULTIPLIERS.items():
                if name.startswith(part):
                    rate *= factor
            if name.endswith("bias"):
                rate *= 2
                if not name.startswith(DECAYING_BIASES):
                    decay = 0.0
        group = {"params": [], "lr": rate, "highest": rate, "weight_decay": decay}
        groups.setdefault((rate, decay), group)["params"].append(parameter)
    groups = list(groups.values())
    if settings.optimiser == "sgd":
        return torch.optim.SGD(groups, lr=settings.learning_rate, momentum=0.9)
    return torch.optim.AdamW(groups, lr=settings.learning_rate, fused=True)
