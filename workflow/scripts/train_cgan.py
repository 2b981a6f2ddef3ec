"""Train the conditional GAN on the observed train scenes and their layers."""

import dataclasses

import torch
from job import job

from lib.training import TrainingRun, Validation, check_memory, enough_memory, logger
from snowsim.cgan import (
    Collapsed,
    Settings,
    Training,
    faults,
    held_out,
    least_bytes,
    measure_losses,
    measure_renders,
    settle_statistics,
    train_steps,
    validate,
)
from snowsim.cgan.health import WINDOW_STEPS
from snowsim.io.files import write_table
from snowsim.io.models import fingerprint, write_model
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.patches import check_trainable

N_SAMPLES = 3  # scenes of the sample sheet


class Judge:
    """Similarity on scenes set aside, and health, of a training as it goes."""

    def __init__(self, training, scenes, train_scenes, statistics, by, *, goes_on=False):
        self.training, self.scenes, self.train_scenes = training, scenes, train_scenes
        self.statistics, self.by, self.goes_on = statistics, by, goes_on
        self.run, self.images = None, []

    def score(self):
        """Similarity, numbers of health, and the fitness that decides; `Collapsed` on collapse unless it goes on."""
        training, settings = self.training, self.training.settings
        rendering = {"dropout": settings.dropout, "statistics": self.statistics, "precision": settings.precision}
        if self.statistics == "training":
            settle_statistics(training, self.train_scenes)
        scores, self.images = validate(training.generator, self.scenes, **rendering, seed=training.seed)
        numbers = measure_losses(self.run.late_losses(WINDOW_STEPS), settings.adversarial)
        numbers |= measure_renders(training.generator, self.scenes, **rendering, seed=training.seed)
        found = faults(numbers, dropout=settings.dropout) if training.step >= WINDOW_STEPS else []
        before = self.run.scores()
        if self.goes_on:
            return {**scores, **numbers, "n_faults": len(found), "fitness": scores[self.by]}
        # Once may pass; twice in a row, or at the end, it has collapsed.
        if found and (training.step == settings.n_steps or (len(before) and before["n_faults"].iloc[-1] > 0)):
            msg = f"step {training.step}: {'; '.join(found)}"
            raise Collapsed(msg)
        return {**scores, **numbers, "n_faults": len(found), "fitness": -float("inf") if found else scores[self.by]}

    def weights(self):
        """What is kept of the best."""
        return self.training.state()["generator"]

    def samples(self):
        """Renders of the first scenes, by name."""
        return {scene.name: image for scene, image in zip(self.scenes[:N_SAMPLES], self.images, strict=False)}


def train(
    paths_to_scenes, path_to_generator, path_to_losses, path_to_validation, path_to_samples,
    seed, device, settings, statistics, validation, on_collapse, source, checkpoint, checkpoint_steps, events,
):  # fmt: skip
    torch.set_num_threads(1)
    settings = Settings(**settings)
    made_of = {
        "settings": dataclasses.asdict(settings),
        "seed": seed,
        "data": fingerprint(paths_to_scenes),
        "validation": validation,
        "statistics": statistics,
    }
    what = f"a cGAN of width {settings.width}"
    check_memory(least_bytes(settings), what)
    with SceneSet(paths_to_scenes) as scenes, enough_memory(what):
        train_numbers, held_numbers = held_out(len(scenes), validation["n_scenes"], seed=seed)
        train_scenes, held_scenes = Chosen(scenes, train_numbers), [scenes[number] for number in held_numbers]
        for scene in held_scenes:
            check_trainable(scene)
        training = Training(settings, seed=seed, device=device)
        judge = Judge(training, held_scenes, train_scenes, statistics, validation["by"], goes_on=on_collapse == "go_on")
        watch = Validation(
            validation["every_steps"], judge.score, judge.weights, "fitness", validation["patience"], judge.samples
        )
        collapse = None
        with TrainingRun(
            training,
            checkpoint,
            {"kind": "unfinished cgan training", **made_of},
            every_steps=checkpoint_steps,
            path_to_events=events,
            validation=watch,
        ) as judge.run:
            run = judge.run
            try:
                run.take(train_steps(training, train_scenes), settings.n_steps, "cGAN")
            except (Collapsed, FloatingPointError) as error:
                run.discard()
                if on_collapse == "fail" or run.best is None:
                    msg = f"cGAN training collapsed at {error}"
                    raise ValueError(msg) from error
                collapse = str(error)
                logger.warning("collapsed at %s; the weights after step %d are kept", collapse, run.best_step)
            best = run.scores().set_index("step").loc[run.best_step]
            if best["n_faults"] > 0:
                collapse = f"step {run.best_step}: {'; '.join(faults(best.to_dict(), dropout=settings.dropout))}"
                logger.warning("collapsed at %s; these weights are kept all the same", collapse)
            metadata = {
                "kind": "cgan generator",
                **made_of,
                "step": run.best_step,
                "steps_taken": training.step,
                "collapse": collapse,
            }
            write_table(path_to_losses, run.losses())
            write_table(path_to_validation, run.scores())
            write_scenes(path_to_samples, sample_scenes(held_scenes, run.samples), {"synthetic": source})
            write_model(path_to_generator, run.best, metadata)


class Chosen:
    """Some of a sequence of scenes, in order, read when asked for."""

    def __init__(self, scenes, numbers):
        self.scenes, self.numbers = scenes, numbers

    def __len__(self):
        return len(self.numbers)

    def __getitem__(self, item):
        return self.scenes[self.numbers[item]]


def sample_scenes(scenes, samples):
    """Each sample scene as observed (its note says step null), then as rendered at every validation."""
    for scene in scenes[:N_SAMPLES]:
        yield dataclasses.replace(scene, complete_layer_bins=None, notes={"step": None})
        for step, images in samples.items():
            yield dataclasses.replace(scene, image=images[scene.name], complete_layer_bins=None, notes={"step": step})


if __name__ == "__main__":
    with job(snakemake):
        train(snakemake.input.train, *snakemake.output, **snakemake.params)
