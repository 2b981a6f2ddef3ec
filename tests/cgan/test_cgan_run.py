"""A training survives kill -9 and leaves its last weights; what ends it is told, and a warning."""

import logging

import numpy as np
import pandas as pd
import pytest
from toy_scenes import toy_scenes
from trainings import check_killed_training, paths_in

from lib.cgan_training import GENERATOR, note_saturation, train
from snowsim.io.models import read_model
from snowsim.io.scenes import write_scenes

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
    files = paths_in(folder, generator="generator.safetensors")
    options = {"seed": 1, "device": "cpu", "settings": SETTINGS}
    return {"scenes": [str(scenes)], **files, **options, "checkpoint_steps": 20, **changes}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Folder of an uninterrupted training."""
    folder = tmp_path_factory.mktemp("trained") / "whole"
    train(**arguments(folder))
    return folder


def test_a_training_killed_midway_ends_with_the_bytes_of_an_uninterrupted_one(whole):
    check_killed_training("lib.cgan_training", arguments(whole.parent / "killed"), whole)
    _, metadata = read_model(whole / "generator.safetensors", GENERATOR)
    assert metadata["step"] == SETTINGS["n_steps"]


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
