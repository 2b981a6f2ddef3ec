"""Scores of one network on validation scenes, by settings that make its training cheaper or dearer."""

import pandas as pd
from job import progress, run

from lib.cgan_training import held_out, train_and_examine
from lib.diagnostics.renderers import trained_alone
from snowsim.cgan import Settings as CganSettings
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream
from snowsim.tracker import Settings


def study(
    train, validation, phy, table,
    *, seed, network, settings, changes, n_trainings, n_held,
):  # fmt: skip
    with SceneSet(train) as scenes, SceneSet(validation) as held, SceneSet(phy) as drawn:
        observed, validated, rendered = list(scenes), list(held), list(drawn)
    numbers = held_out(len(observed), n_held, seed=seed)
    train_scenes, held_scenes = ([observed[number] for number in part] for part in numbers)

    def scores_of(changed, number):
        """Rows of one training: what it was trained on, and its scores."""
        if network == "tracker":
            for name, trained_on in (("rd", observed), ("pd", rendered)):
                yield name, trained_alone(trained_on, validated, Settings(**changed), seed=number)
        else:
            yield "", train_and_examine(CganSettings(**changed), number, train_scenes, held_scenes)

    rows = []
    runs = [(changed, replica) for changed in changes for replica in range(n_trainings)]
    for changed, replica in progress(runs, "budgets"):
        made = {**settings[network], **changed}
        number = int(random_stream(seed, "study_budgets", network, replica).integers(2**31))
        label = ", ".join(f"{key} {value}" for key, value in changed.items())
        for trained_on, scores in scores_of(made, number):
            rows.append(
                {
                    "change": label,
                    "n_steps": made["n_steps"],
                    "trained_on": trained_on,
                    "replica": replica,
                    **scores,
                }
            )
    write_table(table, pd.DataFrame(rows))


run(study)
