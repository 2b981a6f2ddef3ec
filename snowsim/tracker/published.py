"""Training of the tracker by its authors' recipe: network, copies of scenes, loss and updates.

Their code is github.com/BinaLab/MultiScale; their paper is Rahnemoonfar, Yari, Paden, Koenig &
Ibikunle (2021), J. Glaciol. 67.
"""

import numpy as np
import torch
from torch.nn import functional

from snowsim.limits import check_count
from snowsim.patches import whole_copy
from snowsim.tracker.network import STAGES, MultiScaleNetwork, balanced_cross_entropy, enlarge
from snowsim.tracker.sampling import copy_shown
from snowsim.training import Step, arithmetic

MOMENTUM = 0.9
# Factors of the learning rate of the last stage, the sides and the fuse. Biases learn at twice the
# rate of their weights and do not decay. In the last stage they do: the published code misspells
# the key that should prevent it.
MULTIPLIERS = {"stages.4": 100.0, "sides": 0.01, "fuse": 0.001}
DECAYING_BIASES = "stages.4"
# Grey level that the published code subtracts: its means of red, green and blue, weighted as for
# luminance.
MEAN_GREY = 0.299 * 104.00698793 + 0.587 * 116.66876762 + 0.114 * 122.67891434


class PublishedNetwork(MultiScaleNetwork):
    """Multi-scale network with the input, initial weights and side maps of the published code."""

    @staticmethod
    def to_input(images):
        """Grey level less `MEAN_GREY`, float32 (patch, 1, range_bin, range_line)."""
        grey = np.asarray(images).astype(np.float32)
        return torch.from_numpy(grey - np.float32(MEAN_GREY))[:, None]

    @staticmethod
    def enlarged(logit, factors, size):
        """A side map enlarged by `factors` with corners aligned, cut to its central `size`."""
        logit = enlarge(logit, factors, align_corners=True)
        n_rows, n_lines = size
        # Python rounds half a pixel to the even one, as the published code does.
        top = round((logit.shape[2] - n_rows) / 2)
        left = round((logit.shape[3] - n_lines) / 2)
        return logit[:, :, top : top + n_rows, left : left + n_lines]

    def initialise(self, *, rng):
        """Draw weights and biases as PyTorch does by default; the fuse starts as a mean.

        Their law is uniform within +-1 / sqrt(number of inputs).
        """
        with torch.no_grad():
            for name, parameter in self.named_parameters():
                is_bias = name.endswith("bias")
                if name.startswith("fuse"):
                    parameter.fill_(0 if is_bias else 1 / len(STAGES))
                    continue
                if not is_bias:  # a bias comes after its weights and has the same number of inputs
                    n_inputs = parameter[0].numel()
                drawn = rng.uniform(-1, 1, tuple(parameter.shape)) / np.sqrt(n_inputs)
                parameter.copy_(torch.from_numpy(drawn.astype(np.float32)))


def published_optimiser(network, settings, _):
    """Stochastic gradient descent with one group for each pair of rate and decay.

    Groups are few because an update calls the optimiser once for each, and in a small network this
    call takes longer than the arithmetic.
    ValueError for settings that do not apply to copies of whole scenes.
    """
    if settings.batch_size > 1 or settings.n_range_bins or settings.n_range_lines:
        msg = "network published: expected batch_size 1 and no crop"
        raise ValueError(msg)
    groups = {}
    for name, parameter in network.named_parameters():
        rate = settings.learning_rate
        decay = settings.weight_decay
        for part, factor in MULTIPLIERS.items():
            if name.startswith(part):
                rate *= factor
        if name.endswith("bias"):
            rate *= 2
            if not name.startswith(DECAYING_BIASES):
                decay = 0.0
        group = {"params": [], "lr": rate, "highest": rate, "weight_decay": decay}
        groups.setdefault((rate, decay), group)["params"].append(parameter)
    return torch.optim.SGD(list(groups.values()), lr=settings.learning_rate, momentum=MOMENTUM)


def published_rate(settings, n_updates, epoch):
    """Learning rate relative to the highest, after `n_updates` updates and `epoch` epochs."""
    if settings.n_epochs_per_tenth is not None:
        return 0.1 ** (epoch // settings.n_epochs_per_tenth)
    return 0.1 ** (n_updates // settings.n_steps_per_tenth)


def cost_of_probabilities(logits, layer):
    """Cross-entropy of each pixel from float32 probabilities, with logarithms of at least -100."""
    probability = torch.sigmoid(logits.float())
    truth = layer.expand_as(probability)
    return functional.binary_cross_entropy(probability, truth, reduction="none")


def published_training(training, scenes):
    """Two functions: the batch of a step, a scaled or mirrored scene, and the training on it.

    An epoch shows every scene once at each scale and once mirrored, in random order. A step adds a
    gradient to a sum. An update follows `n_accumulated` gradients, counted anew in every epoch;
    gradients left over at the end of an epoch stay in the sum. ValueError if an epoch has too few
    gradients for one update.
    """
    settings = training.settings
    n_per_epoch = settings.n_copies * scenes.n_per_epoch
    n_accumulated = settings.n_accumulated
    check_count("gradients of an epoch", n_per_epoch, n_accumulated)

    def batch_at(step):
        draw, copy = copy_shown(step, scenes.n_per_epoch, settings.n_copies, training.seed)
        is_mirrored = copy == len(settings.scales)
        scale = 1 if is_mirrored else settings.scales[copy]
        image, mask = whole_copy(scenes[draw], scale, is_mirrored)
        return {
            "image": training.network.to_input(image[None]),
            "mask": torch.from_numpy(mask[None]),
        }

    def gradient(batch):
        """Add a gradient to the sum; the loss per pixel of each output, (output,)."""
        with arithmetic(training.device, settings.precision):
            logits = training.network(batch["image"])
        per_output = balanced_cross_entropy(logits, batch["mask"], cost=cost_of_probabilities)
        (per_output.sum() / n_accumulated).backward()
        return per_output.detach() / batch["mask"][0].numel()

    step = Step(gradient, [training.optimiser], training.device)

    def take(batch):
        losses = step(batch)
        epoch, within = divmod(training.step, n_per_epoch)
        if (within + 1) % n_accumulated == 0:
            n_updates = epoch * (n_per_epoch // n_accumulated) + within // n_accumulated
            training.set_rate(published_rate(settings, n_updates, epoch))
            training.update()
        return losses

    return batch_at, take
