"""Training of the tracker, by the small recipe or the published one; resumable exactly."""

import math
from collections.abc import Iterator, Mapping

import torch
from numpy.typing import ArrayLike

from snowsim.constants import OUTPUTS
from snowsim.patches import draw_patches
from snowsim.seeding import random_stream
from snowsim.settings import TrackerSettings
from snowsim.tracker.network import MultiScaleNetwork, PyramidNetwork, balanced_cross_entropy
from snowsim.tracker.published import PublishedNetwork, published_optimiser, published_training
from snowsim.tracker.sampling import TrainingSet
from snowsim.training import (
    Resumable,
    Step,
    arithmetic,
    capturable_optimiser,
    copy_like,
    load_weights,
    on_device,
    run_steps,
    set_rate,
)

WARM_UP = 0.1  # share of the steps during which the learning rate rises


def network_of(settings):
    """Network for `Settings`, before its weights are drawn."""
    if settings.network == "published":
        return PublishedNetwork(settings.width)
    kind = PyramidNetwork if settings.network == "pyramid" else MultiScaleNetwork
    return kind(settings.width, settings.n_averaged)


def trained_network(
    weights: Mapping[str, ArrayLike], settings: TrackerSettings, *, device: str = "cpu"
) -> torch.nn.Module:
    """Network for `track` from its weights (dict of arrays) and the `Settings` of its training."""
    network = load_weights(network_of(settings), weights, "tracker")
    return network.to(device=device, memory_format=torch.channels_last).eval()


class Training(Resumable):
    """State of a training: the network, its optimiser and the number of gradients taken.

    A training resumes from these and the seed, since the scenes of a step depend on seed and step
    alone.

    Parameters
    ----------
    settings : Settings
    seed : int
    device : str
        `cpu` or `cuda`.

    Attributes
    ----------
    network : MultiScaleNetwork, or one of its kinds
    step : int
        Number of gradients taken.
    """

    def __init__(self, settings, *, seed, device="cpu"):
        self.network = network_of(settings)
        self.network.initialise(rng=random_stream(seed, "tracker", "network"))
        super().__init__("tracker", settings, seed, device, {"network": self.network})
        make = published_optimiser if settings.network == "published" else optimiser_of
        self.optimiser = make(self.network, settings, device)
        self.optimisers["optimiser"] = self.optimiser

    def state(self):
        """Everything that a step changes except `step` itself, nested dicts of CPU tensors."""
        sums = {name: weights.grad for name, weights in self.network.named_parameters()}
        return super().state() | {"gradient": on_device(sums, "cpu")}

    def set_rate(self, rate):
        """Set the learning rate of the next update, relative to the highest."""
        for group in self.optimiser.param_groups:
            set_rate(group, group["highest"] * rate)

    def update(self):
        """Update the weights by the summed gradients and set these to zero."""
        self.optimiser.step()
        self.optimiser.zero_grad(set_to_none=False)

    def restore(self, state, step):
        """Continue from a `state`, as arrays, that was saved after `step` steps.

        ValueError if it was made with other settings.
        """
        super().restore(state, step)
        for name, sums in state.get("gradient", {}).items():
            weights = self.network.get_parameter(name)
            weights.grad = copy_like(weights, sums)


def train_steps(
    training: "Training", scenes: TrainingSet, *, n_workers: int = 0
) -> Iterator[tuple[int, dict[str, float]]]:
    """Train to the last step, one gradient at a time, from the step that `training` has reached.

    Parameters
    ----------
    training : Training
        It is changed in place; its `state` may be saved between two steps.
    scenes : TrainingSet
        Or any object that gives the scene of each draw, `scenes[position]`, from 0 without end. The
        published recipe also needs `n_per_epoch`, and workers need `hold`. ValueError if a scene
        has no image or no contrast. The small recipe also refuses a scene without a layer.
    n_workers : int
        Processes that prepare crops in advance, for a GPU; results do not depend on it.

    Yields
    ------
    step : int
        Number of gradients taken. On a GPU only every 50th and the last are given.
    losses : dict of float
        Class-balanced cross-entropy per pixel of each of `OUTPUTS`, and their sum `total`, of this
        step, or on a GPU their means since those given before. FloatingPointError if one is not
        finite.
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
    """Two functions of the small recipe: the batch of a step, random crops, and training on it."""
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
        """Update by the gradient of a batch; its losses per pixel before that, (output,)."""
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
    """Learning rate relative to the highest after `step` steps: linear rise, cosine fall."""
    done = (step + 1) / settings.n_steps
    if done < WARM_UP:
        return done / WARM_UP
    return 0.5 * (1 + math.cos(math.pi * (done - WARM_UP) / (1 - WARM_UP)))


def optimiser_of(network, settings, device):
    """AdamW with one rate and one decay for all weights."""
    rate = settings.learning_rate
    group = {"params": list(network.parameters()), "highest": rate}
    decay = settings.weight_decay
    return capturable_optimiser(torch.optim.AdamW, [group], rate, device, weight_decay=decay)
