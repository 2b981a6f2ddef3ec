"""Scores of a network on validation scenes, by settings that make training cheaper or dearer."""

import pandas as pd
from main_path import progress, run

from evaluation.lib.renderers import trained_alone
from lib.cgan_training import held_out, train_and_examine
from snowsim.cgan import Settings as CganSettings
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream
from snowsim.tracker import Settings


def scenes_of(paths):
    with SceneSet(paths) as scenes:
        return list(scenes)


def study(train, validation, phy, table, *, seed, network, settings, changes, n_trainings, n_held):
    observed = scenes_of(train)
    validated = scenes_of(validation)
    rendered = scenes_of(phy)
    shown, held = held_out(len(observed), n_held, seed=seed)
    train_scenes = [observed[number] for number in shown]
    held_scenes = [observed[number] for number in held]

    def scores_of(changed, number):
        """Scores of one training by what it was trained on."""
        if network == "cgan":
            changed = CganSettings(**changed)
            return {"": train_and_examine(changed, number, train_scenes, held_scenes)}
        changed = Settings(**changed)
        return {
            name: trained_alone(trained_on, validated, changed, seed=number)
            for name, trained_on in (("rd", observed), ("pd", rendered))
        }

    rows = []
    runs = [(changed, replica) for changed in changes for replica in range(n_trainings)]
    for changed, replica in progress(runs, "budgets"):
        made = settings[network] | changed
        number = int(random_stream(seed, "study_budgets", network, replica).integers(2**31))
        label = ", ".join(f"{key} {value}" for key, value in changed.items())
        for trained_on, scores in scores_of(made, number).items():
            row = {
                "change": label,
                "n_steps": made["n_steps"],
                "trained_on": trained_on,
                "replica": replica,
            }
            rows.append(row | scores)
    write_table(table, pd.DataFrame(rows))


run(study)
