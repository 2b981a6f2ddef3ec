"""Train the conditional GAN on the observed train scenes and their layers."""

from job import run

from lib.cgan_training import (
    Recipe,
    Validation,
    description,
    sample_scenes,
    split_scenes,
    take_all_steps,
)
from lib.training import TrainingRun, check_memory, enough_memory
from snowsim.cgan import Settings, Training, least_bytes, train_steps
from snowsim.io.files import write_table
from snowsim.io.models import fingerprint, write_model
from snowsim.io.scenes import SceneSet, write_scenes


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


run(train)
