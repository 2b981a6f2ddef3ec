"""Train the conditional GAN on the observed train scenes and their layers."""

import dataclasses

import torch
from job import job
from training import TrainingRun, enough_memory

from snowsim.cgan import Settings, Training, settle_statistics, train_steps
from snowsim.io.files import write_table
from snowsim.io.models import fingerprint, write_model
from snowsim.io.scenes import SceneSet


def train(
    paths_to_scenes, path_to_generator, path_to_losses, seed, device, settings, checkpoint, checkpoint_steps, events
):  # fmt: skip
    torch.set_num_threads(1)
    settings = Settings(**settings)
    made_of = {"settings": dataclasses.asdict(settings), "seed": seed, "data": fingerprint(paths_to_scenes)}
    with SceneSet(paths_to_scenes) as scenes, enough_memory(f"a cGAN of width {settings.width}"):
        training = Training(settings, seed=seed, device=device)
        unfinished = {"kind": "unfinished cgan training", **made_of}
        with TrainingRun(training, checkpoint, unfinished, every_steps=checkpoint_steps, path_to_events=events) as run:
            run.take(train_steps(training, scenes), settings.n_steps, "cGAN")
            settle_statistics(training, scenes)
            metadata = {"kind": "cgan generator", **made_of, "step": training.step}
            write_table(path_to_losses, run.losses())
            write_model(path_to_generator, training.state()["generator"], metadata)


if __name__ == "__main__":
    with job(snakemake):
        train(snakemake.input.train, snakemake.output.generator, snakemake.output.losses, **snakemake.params)
