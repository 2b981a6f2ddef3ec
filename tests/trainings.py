"""What tests of both networks' trainings share: taking steps, comparing states."""

import torch
from toy_scenes import toy_scenes

from snowsim import cgan, tracker

torch.set_num_threads(1)  # as in every training


def begun(settings, seed=1, n_scenes=3, *, scenes=None, device="cpu", n_workers=0):
    """A training of these settings, and its steps on toy scenes or on those given."""
    scenes = scenes or toy_scenes(n_scenes)
    if isinstance(settings, cgan.Settings):
        training = cgan.Training(settings, seed=seed, device=device)
        return training, cgan.train_steps(training, scenes, n_workers=n_workers)
    training = tracker.Training(settings, seed=seed, device=device)
    shown = tracker.TrainingSet(scenes, seed=seed)
    return training, tracker.train_steps(training, shown, n_workers=n_workers)


def trained(settings, seed=1, n_scenes=3, **how):
    """A training that has taken its steps, and their losses."""
    training, steps = begun(settings, seed, n_scenes, **how)
    return training, [losses for _, losses in steps]


def same(a, b):
    """Whether two nested states hold the same bits."""
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    return torch.equal(a, b)
