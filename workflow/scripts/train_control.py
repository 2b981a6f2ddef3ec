"""Train the tracker on annotated scenes of a flight itself, for as long as suits held-out ones."""

import dataclasses

import pandas as pd
from job import run

from lib.training import TrainingRun
from snowsim.io.files import write_table
from snowsim.io.models import fingerprint, write_model
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream
from snowsim.tracker import (
    Completed,
    Settings,
    Training,
    TrainingSet,
    train_steps,
    trained_network,
)
from snowsim.tracker.calibration import calibrate, fused_logits


def train_control(
    scenes, held, network, calibration, choice,
    *, seed, settings, n_steps, checkpoint, checkpoint_steps,
):  # fmt: skip
    seed = int(random_stream(seed, "train_control").integers(2**31))

    def weights_after(n, paths):
        """Weights after `n` gradients on every layer of the scenes of some files."""
        training = Training(Settings(**settings | {"n_steps": n}), seed=seed)
        expected = {"kind": "unfinished control", "n_steps": n, "data": fingerprint(paths)}
        path = f"{checkpoint}_{n}_{len(paths)}.safetensors"
        with (
            SceneSet(paths) as annotated,
            TrainingRun(training, path, expected, every_steps=checkpoint_steps) as taken,
        ):
            steps = train_steps(training, TrainingSet(Completed(annotated), seed=seed))
            taken.take(steps, n, f"{n} gradients")
        return training.state()["network"]

    with SceneSet([held]) as annotated:
        judges = [Completed(annotated)[place] for place in range(len(annotated))]
    found = {}
    for n in n_steps:
        tried = trained_network(weights_after(n, [scenes]), Settings(**settings))
        logits = [fused_logits(tried, scene.image) for scene in judges]
        found[n] = calibrate(logits, judges)
    best = max(n_steps, key=lambda n: found[n].ods)
    # Chosen on scenes held out, then trained on all.
    weights = weights_after(best, [scenes, held])
    rows = [{"n_steps": n, **dataclasses.asdict(each)} for n, each in found.items()]
    write_table(choice, pd.DataFrame(rows))
    write_table(calibration, pd.DataFrame([dataclasses.asdict(found[best])]))
    metadata = {"kind": "tracker", "settings": settings | {"n_steps": best}, "seed": seed}
    write_model(network, weights, metadata)


run(train_control)
