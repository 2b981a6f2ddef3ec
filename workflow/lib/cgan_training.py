"""What watches a training of the conditional GAN: similarity on held-out scenes, and the detectors of collapse."""

import dataclasses
import time

from lib.cgan_health import WINDOW_STEPS, faults, measure_losses, measure_renders
from lib.patch_distance import scenes_distance
from snowsim.cgan import Training, train_steps, validate
from snowsim.patches import draw_index

N_SAMPLES = 3  # scenes of the sample sheet


class Collapsed(ValueError):
    """A training that detectors found collapsed."""


def held_out(n_scenes, n_held, *, seed):
    """Numbers of the scenes to train on and of those to validate with, two sorted lists; ValueError if none is left."""
    if n_held >= n_scenes:
        msg = f"validation holds {n_held} train scenes out, there are {n_scenes}: none is left to train on"
        raise ValueError(msg)
    held = {draw_index(n_scenes, position, seed, "cgan", "held out") for position in range(n_held)}
    return [number for number in range(n_scenes) if number not in held], sorted(held)


def examine(training, losses, scenes, observed=None):
    """Scores on some scenes, numbers of health, and the renders, of a training as it is."""
    of_it = training.generator, scenes, training.settings
    scores, images = validate(*of_it, seed=training.seed)
    rendered = (
        dataclasses.replace(scene, image=image) for scene, image in zip(scenes, images, strict=True)
    )
    scores["distance"] = scenes_distance(rendered, observed or scenes)
    numbers = measure_losses(losses, training.settings.adversarial) | measure_renders(
        *of_it, seed=training.seed
    )
    return scores, numbers, images


class Validation:
    """Validation of a training by similarity on held-out scenes, and health; `run` is set once the run is open."""

    by = "fitness"

    def __init__(self, training, scenes, validation, *, observed=None, goes_on=False):
        self.training, self.scenes, self.observed, self.goes_on = (
            training,
            scenes,
            observed,
            goes_on,
        )
        self.every_steps, self.patience, self.metric = (
            validation[key] for key in ("every_steps", "patience", "by")
        )
        self.run, self.images = None, []

    def score(self):
        """Similarity, numbers of health, and the fitness that decides; `Collapsed` on collapse unless it goes on."""
        training, settings = self.training, self.training.settings
        late = self.run.late_losses(WINDOW_STEPS)
        scores, numbers, self.images = examine(training, late, self.scenes, self.observed)
        found = faults(numbers, dropout=settings.dropout) if training.step >= WINDOW_STEPS else []
        before = self.run.scores()
        row = {**scores, **numbers, "n_faults": len(found)}
        fitness = {**scores, "last": training.step, "distance": -scores["distance"]}[self.metric]
        if self.goes_on:
            return {**row, "fitness": fitness}
        # Once may pass; twice in a row, or at the end, it has collapsed.
        if found and (
            training.step == settings.n_steps or (len(before) and before["n_faults"].iloc[-1] > 0)
        ):
            msg = f"step {training.step}: {'; '.join(found)}"
            raise Collapsed(msg)
        return {**row, "fitness": -float("inf") if found else fitness}

    def weights(self):
        """What is kept of the best."""
        return self.training.state()["generator"]

    def samples(self):
        """Renders of the first scenes, by name."""
        return {
            scene.name: image
            for scene, image in zip(self.scenes[:N_SAMPLES], self.images, strict=False)
        }


def sample_scenes(scenes, samples):
    """Each sample scene as observed (its note says step null), then as rendered at every validation."""
    for scene in scenes[:N_SAMPLES]:
        yield dataclasses.replace(scene, complete_layer_bins=None, notes={"step": None})
        for step, images in samples.items():
            yield dataclasses.replace(
                scene, image=images[scene.name], complete_layer_bins=None, notes={"step": step}
            )


def train_and_examine(settings, seed, train_scenes, held_scenes, guides=None):
    """Similarity, health, cost and outcome of one training, with `guides` where guided; endless values end it."""
    started = time.process_time()
    training = Training(settings, seed=seed)
    try:
        losses = [step_losses for _, step_losses in train_steps(training, train_scenes, guides)]
        seconds = time.process_time() - started
        rendered = (
            held_scenes
            if guides is None
            else [guides[number] for number in range(len(held_scenes))]
        )
        scores, numbers, _ = examine(training, losses, rendered, held_scenes)
    except FloatingPointError as error:
        return {"outcome": f"values that are not finite: {error}"}
    return {
        **scores,
        **numbers,
        "core_seconds": seconds,
        "outcome": "; ".join(faults(numbers, dropout=settings.dropout)) or "healthy",
    }
