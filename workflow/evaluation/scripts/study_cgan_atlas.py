"""Small trainings of the cGAN over seeds, rates and L1 weights, and what detectors find in each."""

import dataclasses
from itertools import product

import pandas as pd
from main_path import progress, run

from lib.cgan_training import held_out, train_and_examine
from snowsim.cgan import Settings
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet


def study(train, table, *, seed, settings, n_held, n_seeds, learning_rates, l1_weights):
    with SceneSet(train) as scenes:
        train_numbers, held_numbers = held_out(len(scenes), n_held, seed=seed)
        train_scenes = [scenes[number] for number in train_numbers]
        held_scenes = [scenes[number] for number in held_numbers]
    rows = []
    runs = list(product(range(n_seeds), learning_rates, l1_weights))
    for number, learning_rate, l1_weight in progress(runs, "atlas"):
        row = {"seed": seed + number, "learning_rate": learning_rate, "l1_weight": l1_weight}
        changed = dataclasses.replace(
            Settings(**settings), learning_rate=learning_rate, l1_weight=l1_weight
        )
        outcome = train_and_examine(changed, row["seed"], train_scenes, held_scenes)
        rows.append(row | outcome)
    write_table(table, pd.DataFrame(rows))


run(study)
