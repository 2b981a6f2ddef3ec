"""A training survives kill -9 and leaves its last weights; what ends it is told, and a warning."""

import logging
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from toy_scenes import toy_scenes

from lib.cgan_training import GENERATOR, note_saturation, train
from snowsim.io.files import read_table
from snowsim.io.models import read_model
from snowsim.io.scenes import write_scenes

ROOT = Path(__file__).resolve().parents[2]
FILES = {
    "losses": "losses.csv",
    "checkpoint": "unfinished.safetensors",
    "events": "events",
    "generator": "generator.safetensors",
}
# Trains in a process of its own and tells every step it has taken.
CHILD = """
import sys, lib.cgan_training as module
def steps_shown(*arguments, steps=module.train_steps, **options):
    for step, losses in steps(*arguments, **options):
        print(step, flush=True)
        yield step, losses
module.train_steps = steps_shown
module.train(**eval(sys.argv[1]))
"""
SETTINGS = {
    "width": 4,
    "depth": 4,
    "n_range_bins": 64,
    "n_range_lines": 64,
    "precision": "float32",
    "n_steps": 240,
}


def arguments(folder, **changes):
    """Arguments of the training, its files in `folder`, its scenes beside it."""
    scenes = folder.parent / "scenes.nc"
    if not scenes.exists():
        write_scenes(scenes, toy_scenes(6))
    files = {name: str(folder / file) for name, file in FILES.items()}
    options = {"seed": 1, "device": "cpu", "settings": SETTINGS}
    return {"scenes": [str(scenes)], **files, **options, "checkpoint_steps": 20, **changes}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Folder of an uninterrupted training."""
    folder = tmp_path_factory.mktemp("trained") / "whole"
    train(**arguments(folder))
    return folder


def test_a_training_killed_midway_ends_with_the_bytes_of_an_uninterrupted_one(whole):
    given = arguments(whole.parent / "killed")
    checkpoint, n_steps = Path(given["checkpoint"]), SETTINGS["n_steps"]
    names = {path.name for path in whole.iterdir() if path.is_file()}
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "workflow")])}
    command = [sys.executable, "-c", CHILD, repr(given)]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as child:
        for line in child.stdout:
            if int(line) >= 70:  # after 3.5 checkpoints
                child.send_signal(signal.SIGKILL)
                break
    assert child.returncode == -signal.SIGKILL
    assert not names & {path.name for path in checkpoint.parent.iterdir()}
    _, metadata = read_model(checkpoint)
    assert 60 <= metadata["step"] < n_steps
    train(**given)
    for name in names:
        assert (checkpoint.parent / name).read_bytes() == (whole / name).read_bytes()
    assert read_table(given["losses"])["step"].tolist() == list(range(1, n_steps + 1))
    assert not checkpoint.exists()
    _, metadata = read_model(whole / "generator.safetensors", GENERATOR)
    assert metadata["step"] == n_steps


def test_a_loss_that_is_not_finite_ends_the_training_and_leaves_no_checkpoint(tmp_path):
    diverging = {**SETTINGS, "learning_rate": 1e30}
    with pytest.raises(FloatingPointError, match=r"training diverged at step \d+: ") as error:
        train(**arguments(tmp_path / "run", settings=diverging, checkpoint_steps=1))
    assert "\n" not in str(error.value)
    assert [path.name for path in (tmp_path / "run").iterdir()] == ["events"]


@pytest.mark.parametrize(("share", "warns"), [(0.05, True), (0.97, False)])
def test_a_saturated_discriminator_is_noted(share, warns, caplog):
    # Early losses count no more.
    share = np.r_[np.full(50, 1 - share), np.full(200, share)]
    loss = share * np.log(2)
    losses = pd.DataFrame({"discriminator_real": 0.5 * loss, "discriminator_fake": 1.5 * loss})
    with caplog.at_level(logging.WARNING):
        note_saturation(losses)
    assert ("discriminator saturated" in caplog.text) == warns
