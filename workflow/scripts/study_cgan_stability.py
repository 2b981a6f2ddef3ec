"""Small trainings of the cGAN over seeds, learning rates and L1 weights, and what the detectors say of each."""

import dataclasses
from itertools import product

import pandas as pd
import torch
from job import job, progress

from snowsim.cgan import Settings, Training, faults, held_out, measure_losses, measure_renders, train_steps, validate
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet


def judge_one(settings, seed, train_scenes, held_scenes, statistics):
    """Similarity, numbers of health and verdict of one training; a loss that is not finite ends it."""
    training, losses = Training(settings, seed=seed), []
    rendering = {"dropout": settings.dropout, "statistics": statistics, "precision": settings.precision}
    try:
        losses += [step_losses for _, step_losses in train_steps(training, train_scenes)]
        scores, _ = validate(training.generator, held_scenes, **rendering, seed=seed)
    except FloatingPointError as error:
        return {"verdict": f"values that are not finite: {error}"}
    numbers = measure_losses(losses, settings.adversarial)
    numbers |= measure_renders(training.generator, held_scenes, **rendering, seed=seed)
    return {**scores, **numbers, "verdict": "; ".join(faults(numbers, dropout=settings.dropout)) or "healthy"}


def study(paths_to_train, path_to_table, seed, settings, statistics, n_held, n_seeds, learning_rates, l1_weights):
    torch.set_num_threads(1)
    rows = []
    with SceneSet(paths_to_train) as scenes:
        train_numbers, held_numbers = held_out(len(scenes), n_held, seed=seed)
        train_scenes, held_scenes = ([scenes[number] for number in part] for part in (train_numbers, held_numbers))
    runs = list(product(range(n_seeds), learning_rates, l1_weights))
    for number, learning_rate, l1_weight in progress(runs, "stability"):
        here = dataclasses.replace(Settings(**settings), learning_rate=learning_rate, l1_weight=l1_weight)
        run = {"seed": seed + number, "learning_rate": learning_rate, "l1_weight": l1_weight}
        rows.append(run | judge_one(here, seed + number, train_scenes, held_scenes, statistics))
    write_table(path_to_table, pd.DataFrame(rows))


if __name__ == "__main__":
    with job(snakemake):
        study(snakemake.input.train, snakemake.output.table, **snakemake.params)
