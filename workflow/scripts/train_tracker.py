"""Train one tracker on one training set."""

import dataclasses
from contextlib import ExitStack

import torch
from job import job

from lib.training import TrainingRun, enough_memory
from snowsim.io.files import write_table
from snowsim.io.models import fingerprint, write_model
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream
from snowsim.tracker import Chosen, Completed, Settings, Training, TrainingSet, Uppermost, train_steps


def compose(
    real, added, settings, n_epochs, seed, added_per_real, order="mixed", labels="picked", zones=None, n_layers=None
):  # fmt: skip
    """Training set of opened scene sets, and settings with its steps; what differs from the default is an ablation."""
    if labels == "complete":
        real = Completed(real)
    if zones is not None:
        added = [
            Chosen(scenes, [place for place, zone in enumerate(scenes.zones) if zone in zones]) for scenes in added
        ]
    if n_layers is not None:
        added = [Uppermost(scenes, n_layers) for scenes in added]
    scenes = TrainingSet(real, added, added_per_real=added_per_real, seed=seed)
    if n_epochs is not None:
        settings = dataclasses.replace(settings, n_steps=n_epochs * scenes.n_per_epoch // settings.batch_size)
    if order == "synthetic_first":
        n_draws = settings.n_steps * settings.batch_size
        scenes = TrainingSet(real, added, added_per_real=added_per_real, n_draws_synthetic_first=n_draws, seed=seed)
    return scenes, settings


def train(
    paths_to_real, paths_to_added, path_to_network, path_to_losses, seed, replica, device, n_epochs, data, settings,
    checkpoint, checkpoint_steps, events,
):  # fmt: skip
    torch.set_num_threads(1)
    # Of the replica alone: with every training set it starts from the same weights.
    seed = int(random_stream(seed, "train_tracker", replica).integers(2**31))
    settings = Settings(**settings)
    with ExitStack() as opened:
        opened.enter_context(enough_memory(f"a tracker of width {settings.width}"))
        real, *added = (opened.enter_context(SceneSet(paths)) for paths in (paths_to_real, *paths_to_added))
        scenes, settings = compose(real, added, settings, n_epochs, seed, **data)
        made_of = {
            "settings": dataclasses.asdict(settings),
            "seed": seed,
            "scenes": data,
            "data": fingerprint([*paths_to_real, *(path for paths in paths_to_added for path in paths)]),
        }
        training = Training(settings, seed=seed, device=device)
        unfinished = {"kind": "unfinished tracker training", **made_of}
        with TrainingRun(training, checkpoint, unfinished, every_steps=checkpoint_steps, path_to_events=events) as run:
            run.take(train_steps(training, scenes), settings.n_steps, "tracker")
            epochs = training.step * settings.batch_size / scenes.n_per_epoch
            metadata = {"kind": "tracker", **made_of, "step": training.step, "epochs": epochs}
            write_table(path_to_losses, run.losses())
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
