"""What a tracker is trained on in a setting, and for how many steps."""

import dataclasses

from snowsim.tracker import Completed, TrainingSet


def compose(
    real,
    added,
    settings,
    n_epochs,
    seed,
    added_per_real,
    order="mixed",
    labels="picked",
):
    """Training set of opened scene sets, and settings with its steps.

    What differs from the default is an ablation.
    """
    if labels == "complete":
        real = Completed(real)
    scenes = TrainingSet(real, added, added_per_real=added_per_real, seed=seed)
    if n_epochs is not None:
        n_shown = n_epochs * scenes.n_per_epoch * settings.n_copies
        settings = dataclasses.replace(settings, n_steps=n_shown // settings.batch_size)
    if order == "synthetic_first":
        n_draws = settings.n_steps * settings.batch_size // settings.n_copies
        scenes = TrainingSet(
            real, added, added_per_real=added_per_real, n_draws_synthetic_first=n_draws, seed=seed
        )
    return scenes, settings
