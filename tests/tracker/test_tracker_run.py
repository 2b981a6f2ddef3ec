"""A training survives kill -9; what a setting changes is what is shown."""

from dataclasses import replace

import pytest
from toy_scenes import toy_scenes
from trainings import check_killed_training, paths_in

from lib.tracker_training import train
from snowsim.io.scenes import write_scenes


@pytest.fixture
def scene_files(tmp_path):
    """Real scenes and an added set, of which every other scene lies in zone 3."""
    write_scenes(tmp_path / "real.nc", toy_scenes(5))
    added = [
        replace(scene, name=f"added {i}", zone=3 * (i % 2)) for i, scene in enumerate(toy_scenes(8))
    ]
    write_scenes(tmp_path / "added.nc", added)
    return str(tmp_path / "real.nc"), str(tmp_path / "added.nc")


def arguments(folder, scene_files):
    """Arguments of the training, its files in `folder`."""
    options = {
        "seed": 1,
        "replica": "0",
        "device": "cpu",
        "n_epochs": None,
        "checkpoint_steps": 10,
    }
    settings = {
        "width": 2,
        "batch_size": 2,
        "n_steps": 120,
        "n_range_bins": 64,
        "n_range_lines": 48,
    }
    scenes = {
        "real": [scene_files[0]],
        "phy": [scene_files[1]],
        "cgan": [],
        "data": {"added_per_real": 0.6},
    }
    return (
        scenes | options | paths_in(folder, network="network.safetensors") | {"settings": settings}
    )


def test_a_training_killed_midway_ends_with_the_bytes_of_an_uninterrupted_one(
    tmp_path, scene_files
):
    train(**arguments(tmp_path / "whole", scene_files))
    check_killed_training(
        "lib.tracker_training", arguments(tmp_path / "killed", scene_files), tmp_path / "whole"
    )
