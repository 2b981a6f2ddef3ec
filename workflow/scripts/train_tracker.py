"""Train one tracker on one training set."""

import dataclasses
from contextlib import ExitStack

from job import run

from lib.tracker_training import compose
from lib.training import TrainingRun, enough_memory
from snowsim.io.files import write_table
from snowsim.io.models import fingerprint, write_model
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream
from snowsim.tracker import Settings, Training, train_steps


def train(
    real, phy, cgan, network, losses,
    *, seed, replica, device, n_epochs, data, settings, skip, checkpoint, checkpoint_steps, events,
):  # fmt: skip
    # Of the replica alone: with every training set it starts from the same weights.
    seed = int(random_stream(seed, "train_tracker", replica).integers(2**31))
    settings = Settings(**settings)
    with ExitStack() as opened:
        opened.enter_context(enough_memory(f"a tracker of width {settings.width}"))
        given = [paths for paths in (real, phy, cgan) if paths]
        observed, *added = (opened.enter_context(SceneSet(paths)) for paths in given)
        scenes, settings = compose(observed, added, settings, n_epochs, seed, **data)
        made_of = {
            "settings": dataclasses.asdict(settings),
            "seed": seed,
            "scenes": data,
            "skip": skip,
            "data": fingerprint([*real, *phy, *cgan]),
        }
        training = Training(settings, seed=seed, device=device)
        # A share of the schedule passes without a gradient: a control for what other trainings
        # begin with.
        n_skipped = round(skip * settings.n_steps)
        training.step = n_skipped
        unfinished = {"kind": "unfinished tracker training", **made_of}
        kept = {"every_steps": checkpoint_steps, "path_to_events": events}
        with TrainingRun(training, checkpoint, unfinished, **kept) as taken:
            taken.take(train_steps(training, scenes), settings.n_steps, "tracker")
            n_shown = (training.step - n_skipped) * settings.batch_size
            epochs = n_shown / (settings.n_copies * scenes.n_per_epoch)
            metadata = {"kind": "tracker", **made_of, "step": training.step, "epochs": epochs}
            write_table(losses, taken.losses())
            write_model(network, training.state()["network"], metadata)


run(train)
