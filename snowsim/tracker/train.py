"""Training of the tracker by the small recipe or the published one, resumable to the byte."""

import math

import torch

from snowsim.constants import OUTPUTS
from snowsim.patches import draw_patches
from snowsim.seeding import random_stream
from snowsim.tracker.network import MultiScaleNetwork, PyramidNetwork, balanced_cross_entropy
from snowsim.tracker.published import PublishedNetwork, published_optimiser, published_training
from snowsim.training import (
    Resumable,
    Step,
    adaptive,
    arithmetic,
    copy_like,
    load_weights,
    on_device,
    run_steps,
    set_rate,
)

WARM_UP = 0.1  # share of the steps during which the learning rate rises


def network_of(settings):
    """A network by its `Settings`; its weights are not yet drawn."""
    if settings.network == "published":
        return PublishedNetwork(settings.width)
    kind = PyramidNetwork if settings.network == "pyramid" else MultiScaleNetwork
    return kind(settings.width, settings.n_averaged)


def trained_network(weights, settings, *, device="cpu"):
    """Network for `track` from weights (dict of arrays) and the `Settings` of their training."""
    network = load_weights(network_of(settings), weights, "tracker")
    return network.to(device=device, memory_format=torch.channels_last).eval()


class Training(Resumable):
    """The network, its optimiser and the number of gradients taken.

    A training resumes from these and its seed, since what a step draws depends on seed and step
    alone.

    Parameters
    ----------
    settings : Settings
    seed : int
    device : str
        Where to train, `cpu` or `cuda`.

    Attributes
    ----------
    network : MultiScaleNetwork, or one of its kinds
    step : int
        Gradients taken.
    """

    def __init__(self, settings, *, seed, device="cpu"):
        self.network = network_of(settings)
        self.network.initialise(rng=random_stream(seed, "tracker", "network"))
        super().__init__("tracker", settings, seed, device, {"network": self.network})
        make = published_optimiser if settings.network == "published" else optimiser_of
        self.optimiser = make(self.network, settings, device)
        self.optimisers["optimiser"] = self.optimiser

    def state(self):
        """All that a step changes, except `step` itself, as nested dicts of CPU tensors."""
        sums = {name: weights.grad for name, weights in self.network.named_parameters()}
        return super().state() | {"gradient": on_device(sums, "cpu")}

    def set_rate(self, rate):
        """Set the learning rate of the next update, relative to the highest."""
        for group in self.optimiser.param_groups:
            set_rate(group, group["highest"] * rate)

    def update(self):
        """Change the weights by the summed gradients, which are then zeros."""
        self.optimiser.step()
        self.optimiser.zero_grad(set_to_none=False)

    def restore(self, state, step):
        """Go on from a `state`, as arrays, that was kept after `step` steps.

        ValueError if other settings made it.
        """
        super().restore(state, step)
        for name, sums in state.get("gradient", {}).items():
            weights = self.network.get_parameter(name)
            weights.grad = copy_like(weights, sums)


def train_steps(training, scenes, *, n_workers=0):
    """Train from where `training` is to its last step, one gradient at a time.

    Parameters
    ----------
    training : Training
        Changed in place; between two steps its `state` may be saved.
    scenes : TrainingSet
        Or anything else that gives the scene of each draw, `scenes[position]`, from 0 without end;
        the published recipe also needs `n_per_epoch`, and workers `hold`. ValueError if a scene has
        no image or no contrast, or no layer, which the published recipe allows.
    n_workers : int
        Processes that prepare crops ahead, for a GPU; results do not depend on it.

    Yields
    ------
    step : int
        Gradients taken, counted from 1; on a GPU every 50 and the last.
    losses : dict of float
        Class-balanced cross-entropy per pixel of each of `OUTPUTS`, and their sum `total`, of this
        step; on a GPU means since the last that was given. FloatingPointError if one is not finite.
    """
    settings = training.settings
    if n_workers:
        scenes.hold()
    if settings.network == "published":
        batch_at, take = published_training(training, scenes)
    else:
        batch_at, take = small_training(training, scenes)
    for step, losses in run_steps(training, batch_at, take, OUTPUTS, n_workers=n_workers):
        yield step, losses | {"total": sum(losses.values())}


def small_training(training, scenes):
    """The batch of every step by the small recipe, random crops, and the function that takes it."""
    settings = training.settings

    def batch_at(step):
        first = step * settings.batch_size
        images, masks = draw_patches(
            [scenes[first + place] for place in range(settings.batch_size)],
            settings.n_range_bins,
            settings.n_range_lines,
            flip=settings.flip,
            rng=random_stream(training.seed, "tracker", "step", step),
        )
        return {"image": training.network.to_input(images), "mask": torch.from_numpy(masks)}

    def gradient(batch):
        """Update by the gradient of a batch; the losses per pixel before, (output,)."""
        with arithmetic(training.device, settings.precision):
            logits = training.network(batch["image"])
        per_output = balanced_cross_entropy(logits, batch["mask"], layer_share=settings.layer_share)
        per_pixel = per_output / batch["mask"][0].numel()
        per_pixel.sum().backward()
        training.update()
        return per_pixel.detach()

    step = Step(gradient, [training.optimiser], training.device)

    def take(batch):
        training.set_rate(rate_factor(settings, training.step))
        return step(batch)

    return batch_at, take


def rate_factor(settings, step):
    """Rate relative to the highest, after `step` steps: a linear rise and a cosine fall."""
    done = (step + 1) / settings.n_steps
    if done < WARM_UP:
        return done / WARM_UP
    return 0.5 * (1 + math.cos(math.pi * (done - WARM_UP) / (1 - WARM_UP)))


def optimiser_of(network, settings, device):
    """AdamW with one rate and one decay for all weights."""
    rate = settings.learning_rate
    group = {"params": list(network.parameters()), "highest": rate}
    decay = settings.weight_decay
    return adaptive(torch.optim.AdamW, [group], rate, device, weight_decay=decay)
