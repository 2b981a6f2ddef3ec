"""Train the conditional GAN on the observed train scenes and their layers."""

import dataclasses

import pandas as pd
import torch
from job import job, progress

from snowsim.cgan import Settings, Training, settle_statistics, train_steps
from snowsim.io.files import write_table
from snowsim.io.models import fingerprint, write_model
from snowsim.io.scenes import SceneSet


def train(paths_to_scenes, path_to_generator, path_to_losses, seed, device, settings):
    torch.set_num_threads(1)
    settings = Settings(**settings)
    training = Training(settings, seed=seed, device=device)
    rows = []
    with SceneSet(paths_to_scenes) as scenes:
        steps = progress(train_steps(training, scenes), "cGAN", total=settings.n_steps)
        for step, losses in steps:
            rows.append({"step": step, **losses})
            if step % 50 == 0:
                steps.set_postfix({name: f"{value:.3f}" for name, value in losses.items()}, refresh=False)
        settle_statistics(training, scenes)
    metadata = {
        "kind": "cgan generator",
        "settings": dataclasses.asdict(settings),
        "seed": seed,
        "step": training.step,
        "data": fingerprint(paths_to_scenes),
    }
    write_table(path_to_losses, pd.DataFrame(rows))
    write_model(path_to_generator, training.state()["generator"], metadata)


if __name__ == "__main__":
    with job(snakemake):
        train(snakemake.input.train, snakemake.output.generator, snakemake.output.losses, **snakemake.params)
