"""Train one tracker on one training set."""

import dataclasses
from contextlib import ExitStack

import pandas as pd
import torch
from job import job, progress

from snowsim.io.files import write_table
from snowsim.io.models import fingerprint, write_model
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream
from snowsim.tracker import Chosen, Completed, Settings, Training, TrainingSet, train_steps


def compose(real, added, n_draws, seed, added_per_real, order="mixed", labels="picked", zones=None):
    """Training set of opened scene sets; what differs from the default is an ablation."""
    if labels == "complete":
        real = Completed(real)
    if zones is not None:
        added = [
            Chosen(scenes, [place for place, zone in enumerate(scenes.zones) if zone in zones]) for scenes in added
        ]
    first = n_draws if order == "synthetic_first" else None
    return TrainingSet(real, added, added_per_real=added_per_real, n_draws_synthetic_first=first, seed=seed)


def train(
    paths_to_real, paths_to_added, path_to_network, path_to_losses, seed, replica, device, n_epochs, data, settings
):
    torch.set_num_threads(1)
    # Of the replica alone: with every training set it starts from the same weights.
    seed = int(random_stream(seed, "train_tracker", replica).integers(2**31))
    with ExitStack() as opened:
        real, *added = (opened.enter_context(SceneSet(paths)) for paths in (paths_to_real, *paths_to_added))
        settings = Settings(**settings)
        scenes = compose(real, added, settings.n_steps * settings.batch_size, seed, **data)
        if n_epochs is not None:
            settings = dataclasses.replace(settings, n_steps=n_epochs * scenes.n_per_epoch // settings.batch_size)
        training = Training(settings, seed=seed, device=device)
        rows = []
        steps = progress(train_steps(training, scenes), "tracker", total=settings.n_steps)
        for step, losses in steps:
            rows.append({"step": step, **losses})
            if step % 50 == 0:
                steps.set_postfix(total=f"{losses['total']:.4f}", refresh=False)
    metadata = {
        "kind": "tracker",
        "settings": dataclasses.asdict(settings),
        "seed": seed,
        "step": training.step,
        "epochs": training.step * settings.batch_size / scenes.n_per_epoch,
        "data": fingerprint([*paths_to_real, *(path for paths in paths_to_added for path in paths)]),
    }
    write_table(path_to_losses, pd.DataFrame(rows))
    write_model(path_to_network, training.state()["network"], metadata)


if __name__ == "__main__":
    with job(snakemake):
        train(
            snakemake.input.real,
            [paths for paths in (snakemake.input.phy, snakemake.input.cgan) if paths],
            snakemake.output.network,
            snakemake.output.losses,
            replica=snakemake.wildcards.replica,
            **snakemake.params,
        )
