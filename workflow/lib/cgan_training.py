"""What watches a training of the conditional GAN: similarity on scenes set aside, and the detectors of collapse."""

import dataclasses

from snowsim.cgan import Collapsed, faults, measure_losses, measure_renders, settle_statistics, validate
from snowsim.cgan.health import WINDOW_STEPS

N_SAMPLES = 3  # scenes of the sample sheet


class Chosen:
    """Some of a sequence of scenes, in order, read when asked for."""

    def __init__(self, scenes, numbers):
        self.scenes, self.numbers = scenes, numbers

    def __len__(self):
        return len(self.numbers)

    def __getitem__(self, item):
        return self.scenes[self.numbers[item]]


class Judge:
    """Similarity on scenes set aside, and health, of a training as it goes; `run` is set once the run is open."""

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
        told = {**scores, **numbers, "n_faults": len(found)}
        if self.goes_on:
            return {**told, "fitness": scores[self.by]}
        # Once may pass; twice in a row, or at the end, it has collapsed.
        if found and (training.step == settings.n_steps or (len(before) and before["n_faults"].iloc[-1] > 0)):
            msg = f"step {training.step}: {'; '.join(found)}"
            raise Collapsed(msg)
        return {**told, "fitness": -float("inf") if found else scores[self.by]}

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
