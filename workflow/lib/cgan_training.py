"""A training of the conditional GAN, watched: similarity on held-out scenes, and detectors."""

import logging
from dataclasses import asdict, dataclass, replace

import numpy as np
from torch.utils.data import Subset

from lib.cgan_health import WINDOW_STEPS, faults, is_early, measure_losses, measure_renders
from lib.patch_distance import scenes_distance
from lib.training import TrainingRun, check_memory, enough_memory
from snowsim.cgan import Settings, Training, least_bytes, train_steps, validate
from snowsim.cgan.fades import fade_spread
from snowsim.cgan.scope import scope_of
from snowsim.io.files import write_table
from snowsim.io.models import fingerprint, write_model
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.patches import check_trainable, draw_index

N_SAMPLES = 3  # scenes of the sample sheet

logger = logging.getLogger("snowsim")


class Collapsed(ValueError):
    """A training that detectors found collapsed."""


@dataclass(frozen=True)
class Recipe:
    """What a training is made by, `validation` and `on_collapse` as in the configuration."""

    settings: Settings
    seed: int
    device: str
    validation: dict
    on_collapse: str

    def made_of(self, data):
        """What decides the weights, given the fingerprint of the scenes: for headers of files."""
        return {
            "settings": asdict(self.settings),
            "seed": self.seed,
            "data": data,
            "validation": self.validation,
        }


def held_out(n_scenes, n_held, *, seed):
    """Numbers of the scenes to train on and of those to validate with, two sorted lists.

    ValueError if none is left.
    """
    if n_held >= n_scenes:
        msg = f"validation holds {n_held} train scenes out, there are {n_scenes}: "
        msg += "none is left to train on"
        raise ValueError(msg)
    held = {draw_index(n_scenes, position, seed, "cgan", "held out") for position in range(n_held)}
    return [number for number in range(n_scenes) if number not in held], sorted(held)


def split_scenes(scenes, recipe):
    """Scenes to train on, read when needed, and those to validate with.

    ValueError for one of the latter that cannot be rendered.
    """
    n_held = recipe.validation["n_scenes"]
    train_numbers, held_numbers = held_out(len(scenes), n_held, seed=recipe.seed)
    held_scenes = [scenes[number] for number in held_numbers]
    for scene in held_scenes:
        check_trainable(scene)
    return Subset(scenes, train_numbers), held_scenes


def take_all_steps(taken, steps, recipe):
    """Take the steps that a `TrainingRun` has left and say whether it collapsed: in words, or None.

    ValueError on collapse where `on_collapse` is `fail`, or where no healthy weights are there.
    """
    settings = recipe.settings
    try:
        taken.take(steps, settings.n_steps, "cGAN")
    except (Collapsed, FloatingPointError) as error:
        taken.discard()
        if recipe.on_collapse == "fail" or taken.best is None:
            msg = f"cGAN training collapsed at {error}"
            raise ValueError(msg) from error
        logger.warning(
            "collapsed at %s; the weights after step %d are kept", error, taken.best_step
        )
        collapse = str(error)
    else:
        collapse = None
    best = taken.scores().set_index("step").loc[taken.best_step]
    if best["n_faults"] > 0:
        found = faults(
            best.to_dict(),
            dropout=settings.dropout,
            early=is_early(taken.best_step, settings.n_steps),
        )
        collapse = f"step {taken.best_step}: {'; '.join(found)}"
        logger.warning("collapsed at %s; these weights are kept all the same", collapse)
    return collapse


def description(taken, made_of, collapse, train_scenes):
    """What the file of the generator says of it."""
    return {
        "kind": "cgan generator",
        **made_of,
        "step": taken.best_step,
        "steps_taken": taken.training.step,
        "collapse": collapse,
        "scope": scope_of(train_scenes),
        "fade_spread": fade_spread(train_scenes),
    }


@dataclass(frozen=True)
class Examined:
    """A training as it is: similarity to observed scenes, numbers of health, and the renders."""

    scores: dict
    health: dict
    images: list


def examine(training, losses, scenes):
    """`Examined` of a training with these losses, on observed scenes."""
    settings = training.settings
    scores, images = validate(training.generator, scenes, settings, seed=training.seed)
    pairs = zip(scenes, images, strict=True)
    rendered = [replace(scene, image=image) for scene, image in pairs]
    scores["distance"] = scenes_distance(rendered, scenes)
    health = measure_losses(losses)
    health |= measure_renders(training.generator, scenes, settings, seed=training.seed)
    return Examined(scores, health, images)


class Validation:
    """Validation of a training by similarity on held-out scenes, and health.

    `run` is set once the run is open.
    """

    by = "fitness"

    def __init__(self, training, scenes, recipe):
        self.training = training
        self.scenes = scenes
        self.every_steps = recipe.validation["every_steps"]
        self.patience = recipe.validation["patience"]
        self.metric = recipe.validation["by"]
        self.goes_on = recipe.on_collapse == "go_on"
        self.run = None
        self.images = []

    def score(self):
        """Similarity, numbers of health, and the fitness that decides.

        `Collapsed` on collapse unless it goes on.
        """
        step = self.training.step
        settings = self.training.settings
        examined = examine(self.training, self.run.late_losses(WINDOW_STEPS), self.scenes)
        self.images = examined.images
        found = []
        if step >= WINDOW_STEPS:
            found = faults(
                examined.health,
                dropout=settings.dropout,
                early=is_early(step, settings.n_steps),
            )
        # Once may pass; twice in a row, or at the end, it has collapsed.
        is_final = step == settings.n_steps or self._was_faulty()
        if found and is_final and not self.goes_on:
            msg = f"step {step}: {'; '.join(found)}"
            raise Collapsed(msg)
        is_refused = found and not self.goes_on
        fitness = -np.inf if is_refused else self._fitness(examined.scores)
        row = examined.scores | examined.health
        return row | {"n_faults": len(found), "fitness": fitness}

    def _was_faulty(self):
        """Whether the validation before this one found faults."""
        before = self.run.scores()
        return len(before) > 0 and before["n_faults"].iloc[-1] > 0

    def _fitness(self, scores):
        if self.metric == "last":
            return self.training.step
        # The only score that is better where it is smaller.
        return -scores["distance"] if self.metric == "distance" else scores[self.metric]

    def weights(self):
        """What is kept of the best."""
        return self.training.state()["generator"]

    def samples(self):
        """Renders of the first scenes, by name."""
        pairs = zip(self.scenes[:N_SAMPLES], self.images, strict=False)
        return {scene.name: image for scene, image in pairs}


def sample_scenes(scenes, samples):
    """Each sample scene as observed (its note says step null), then as every validation saw it."""
    for scene in scenes[:N_SAMPLES]:
        yield replace(scene, complete_layer_bins=None, notes={"step": None})
        for step, images in samples.items():
            image = images[scene.name]
            yield replace(scene, image=image, complete_layer_bins=None, notes={"step": step})


def train(
    scenes, generator, losses, scores, samples,
    *, settings, checkpoint, checkpoint_steps, events, source, **options,
):  # fmt: skip
    """Train by the `Recipe` of `settings` and `options`, from the checkpoint where there is one."""
    recipe = Recipe(Settings(**settings), **options)
    made_of = recipe.made_of(fingerprint(scenes))
    what = f"a cGAN of width {recipe.settings.width}"
    check_memory(least_bytes(recipe.settings), what)
    with SceneSet(scenes) as observed, enough_memory(what):
        train_scenes, held_scenes = split_scenes(observed, recipe)
        training = Training(recipe.settings, seed=recipe.seed, device=recipe.device)
        validation = Validation(training, held_scenes, recipe)
        unfinished = TrainingRun(
            training,
            checkpoint,
            {"kind": "unfinished cgan training", **made_of},
            every_steps=checkpoint_steps,
            path_to_events=events,
            validation=validation,
        )
        with unfinished as taken:
            validation.run = taken
            collapse = take_all_steps(taken, train_steps(training, train_scenes), recipe)
            # Within the block: only a training whose files are written needs no checkpoint.
            write_table(losses, taken.losses())
            write_table(scores, taken.scores())
            write_scenes(samples, sample_scenes(held_scenes, taken.samples), {"synthetic": source})
            metadata = description(taken, made_of, collapse, train_scenes)
            write_model(generator, taken.best, metadata)
