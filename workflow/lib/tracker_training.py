"""A training of the tracker: its scenes, its number of steps, and the files that it writes."""

import dataclasses
from contextlib import ExitStack

from torch.utils.data import Subset

from lib.training import TrainingRun, enough_memory
from snowsim.io.files import write_table
from snowsim.io.models import fingerprint, write_model
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream
from snowsim.tracker import Completed, Settings, Training, TrainingSet, train_steps


def compose(
    real,
    added,
    settings,
    n_epochs,
    seed,
    added_per_real,
    labels="picked",
    n_real=None,
):
    """The `TrainingSet` of opened scene sets, and settings with the number of steps of `n_epochs`.

    Without `n_epochs` the number of steps stays that of the settings. Studies train on the first
    `n_real` real scenes, or on `complete` labels.
    """
    if n_real is not None:
        real = Subset(real, range(n_real))
    if labels == "complete":
        real = Completed(real)
    scenes = TrainingSet(real, added, added_per_real=added_per_real, seed=seed)
    if n_epochs is not None:
        n_shown = n_epochs * scenes.n_per_epoch * settings.n_copies
        settings = dataclasses.replace(settings, n_steps=n_shown // settings.batch_size)
    return scenes, settings


def train(
    real,
    phy,
    cgan,
    own,
    network,
    losses,
    *,
    seed,
    replica,
    device,
    n_epochs,
    data,
    settings,
    threads=1,
    **kept,
):
    """Train one tracker on the files of its training set, from its checkpoint if there is one.

    `data` are the options of `compose`, `kept` those of `TrainingRun`. Threads beside the first
    prepare inputs.
    """
    # The seed depends on the replica alone, so that all training sets start from the same weights.
    seed = int(random_stream(seed, "train_tracker", replica).integers(2**31))
    settings = Settings(**settings)
    with ExitStack() as opened:
        opened.enter_context(enough_memory(f"a tracker of width {settings.width}"))
        observed, *added = [
            opened.enter_context(SceneSet(paths)) for paths in (real, phy, cgan, own) if paths
        ]
        scenes, settings = compose(observed, added, settings, n_epochs, seed, **data)
        made_of = {
            "settings": dataclasses.asdict(settings),
            "seed": seed,
            "scenes": data,
            "data": fingerprint([*real, *phy, *cgan, *own]),
        }
        training = Training(settings, seed=seed, device=device)
        unfinished = {"kind": "unfinished tracker training", **made_of}
        steps = train_steps(training, scenes, n_workers=threads - 1)
        with TrainingRun(training, unfinished, **kept) as taken:
            taken.take(steps, settings.n_steps, "tracker")
            n_shown = training.step * settings.batch_size
            epochs = n_shown / (settings.n_copies * scenes.n_per_epoch)
            metadata = {"kind": "tracker", **made_of, "step": training.step, "epochs": epochs}
            write_table(losses, taken.losses())
            write_model(network, training.state()["network"], metadata)
