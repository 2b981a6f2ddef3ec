"""What watches a training of the conditional GAN: similarity on held-out scenes, and the detectors of collapse."""

import dataclasses

from snowsim.cgan import Collapsed, faults, measure_losses, measure_renders, settle_statistics, validate
from snowsim.cgan.health import WINDOW_STEPS

N_SAMPLES = 3  # scenes of the sample sheet


def examine(training, losses, scenes, statistics):
    """Similarity on some scenes, numbers of health, and the renders, of a training as it is."""
    settings = training.settings
    options = {"dropout": settings.dropout, "precision": settings.precision, "seed": training.seed}
    scores, images = validate(training.generator, scenes, statistics=statistics, **options)
    numbers = measure_losses(losses, settings.adversarial)
    numbers |= measure_renders(training.generator, scenes, statistics=statistics, **options)
    return scores, numbers, images


class Validation:
    """Validation of a training by similarity on held-out scenes, and health; `run` is set once the run is open."""

    by = "fitness"

    def __init__(self, training, scenes, train_scenes, statistics, validation, *, goes_on=False):
        self.training, self.scenes, self.train_scenes = training, scenes, train_scenes
        self.statistics, self.goes_on = statistics, goes_on
        self.every_steps, self.patience, self.metric = (validation[key] for key in ("every_steps", "patience", "by"))
        self.run, self.images = None, []

    def score(self):
        """Similarity, numbers of health, and the fitness that decides; `Collapsed` on collapse unless it goes on."""
        training, settings = self.training, self.training.settings
        if self.statistics == "training":
            settle_statistics(training, self.train_scenes)
        late = self.run.late_losses(WINDOW_STEPS)
        scores, numbers, self.images = examine(training, late, self.scenes, self.statistics)
        found = faults(numbers, dropout=settings.dropout) if training.step >= WINDOW_STEPS else []
        before = self.run.scores()
        row = {**scores, **numbers, "n_faults": len(found)}
        fitness = training.step if self.metric == "last" else scores[self.metric]
        if self.goes_on:
            return {**row, "fitness": fitness}
        # Once may pass; twice in a row, or at the end, it has collapsed.
        if found and (training.step == settings.n_steps or (len(before) and before["n_faults"].iloc[-1] > 0)):
            msg = f"step {training.step}: {'; '.join(found)}"
            raise Collapsed(msg)
        return {**row, "fitness": -float("inf") if found else fitness}

    def weights(self):
        """What is kept of the best."""
        return self.training.state()["generator"]

    def samples(self):
        """Renders of the first scenes, by name."""
        return {scene.name: image for scene, image in zip(self.scenes[:N_SAMPLES], self.images, strict=False)}


def sample_scenes(scenes, samples):
    """Each sample scene as observed (its note says step null), then as rendered at every validation."""
    for scene in scenes[:N_SAMPLES]:
        yield dataclasses.replace(scene, complete_layer_bins=None, notes={"step": None})
        for step, images in samples.items():
            yield dataclasses.replace(scene, image=images[scene.name], complete_layer_bins=None, notes={"step": step})
