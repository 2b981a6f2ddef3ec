"""A training survives kill -9; a collapse is stated."""

from dataclasses import replace

import numpy as np
import pytest
from toy_scenes import toy_scenes
from trainings import check_killed_training, paths_in

from lib import cgan_training
from lib.cgan_training import train
from snowsim.io.files import read_table
from snowsim.io.models import read_model
from snowsim.io.scenes import SceneSet, write_scenes

SMALL = {
    "width": 4,
    "depth": 4,
    "n_strided": 1,
    "n_range_bins": 64,
    "n_range_lines": 64,
    "precision": "float32",
}
SETTINGS = {**SMALL, "n_steps": 240}
SHORT = {**SETTINGS, "n_steps": 80, "n_range_bins": 32, "n_range_lines": 32, "depth": 3}
VALIDATION = {"n_scenes": 2, "every_steps": 50, "by": "distance", "patience": None}


def arguments(folder, **changes):
    """Arguments of the training, its files in `folder`, its scenes beside it."""
    scenes = folder.parent / "scenes.nc"
    if not scenes.exists():
        write_scenes(scenes, toy_scenes(6))
    files = paths_in(
        folder, generator="generator.safetensors", scores="validation.csv", samples="samples.nc"
    )
    options = {
        "seed": 1,
        "device": "cpu",
        "settings": SETTINGS,
        "validation": VALIDATION,
        "on_collapse": "fail",
    }
    return {
        "scenes": [str(scenes)],
        **files,
        **options,
        "source": "no",
        "checkpoint_steps": 20,
        **changes,
    }


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Folder of an uninterrupted training."""
    folder = tmp_path_factory.mktemp("trained") / "whole"
    train(**arguments(folder))
    return folder


def test_a_training_killed_midway_ends_with_the_bytes_of_an_uninterrupted_one(whole):
    check_killed_training("lib.cgan_training", arguments(whole.parent / "killed"), whole)


def test_the_weights_are_those_of_the_best_validation_and_samples_hold_each_scene_at_every_one(
    whole,
):
    scores = read_table(whole / "validation.csv")
    assert scores["step"].tolist() == [50, 100, 150, 200, 240]
    _, metadata = read_model(
        whole / "generator.safetensors", {"kind": "cgan generator", "collapse": None}
    )
    assert metadata["step"] == scores["step"][scores["distance"].idxmin()]
    assert metadata["steps_taken"] == SETTINGS["n_steps"]
    with SceneSet(whole / "samples.nc") as samples:
        sheets = [(sample.name, sample.notes["step"]) for sample in samples]
        observed = {scene.name: scene for scene in toy_scenes(6)}
        for sample in samples:
            is_observed = (sample.image == observed[sample.name].image).all()
            assert is_observed == (sample.notes["step"] is None)
    names = sorted({name for name, _ in sheets})
    assert len(names) == 2
    steps = (None, 50, 100, 150, 200, 240)
    expected = [(name, step) for name in names for step in steps]
    assert sorted(sheets, key=str) == sorted(expected, key=str)


def test_the_last_weights_are_kept_where_that_is_asked(tmp_path):
    validation = {**VALIDATION, "by": "last", "every_steps": 20}
    train(**arguments(tmp_path, settings=SHORT, validation=validation, on_collapse="go_on"))
    _, metadata = read_model(tmp_path / "generator.safetensors")
    assert metadata["step"] == SHORT["n_steps"]


@pytest.fixture
def collapse(tmp_path, monkeypatch):
    """Train with a fault planted in all validations from a step on; what the weights' file says."""

    def train_on(first_step, on_collapse, every_steps=10):
        def planted(losses):
            return {"mask_response": 0.0 if losses[-1]["step"] >= first_step else 1.0}

        monkeypatch.setattr(cgan_training, "WINDOW_STEPS", 20)
        monkeypatch.setattr(cgan_training, "measure_losses", planted)
        monkeypatch.setattr(cgan_training, "measure_renders", lambda *arguments, **options: {})
        validation = {**VALIDATION, "every_steps": every_steps}
        train(
            **arguments(
                tmp_path / "run", settings=SHORT, validation=validation, on_collapse=on_collapse
            )
        )
        return read_model(tmp_path / "run/generator.safetensors")[1]

    return train_on


def test_a_collapse_says_so_and_fails(tmp_path, collapse):
    with pytest.raises(
        ValueError, match=r"cGAN training collapsed at step 60: mask ignored"
    ) as error:
        collapse(45, "fail")
    assert "\n" not in str(error.value)
    assert [path.name for path in (tmp_path / "run").iterdir()] == ["events"]


def test_a_collapse_falls_back_to_the_last_good_weights_and_states_it(tmp_path, collapse, caplog):
    metadata = collapse(45, "fall_back")
    assert metadata["collapse"].startswith("step 60: mask ignored")
    assert metadata["step"] <= 40
    assert f"the weights after step {metadata['step']} are kept" in caplog.text
    assert read_table(tmp_path / "run/validation.csv")["step"].tolist() == [10, 20, 30, 40, 50]


def test_a_collapse_before_any_good_weights_fails_whatever_the_setting(collapse):
    with pytest.raises(ValueError, match="collapsed at step 80"):
        collapse(
            0, "fall_back", every_steps=40
        )  # from step 20 on losses are checked: no weights count as good


def test_a_collapse_that_goes_on_keeps_the_best_and_states_its_faults(tmp_path, collapse, caplog):
    metadata = collapse(0, "go_on")
    scores = read_table(tmp_path / "run/validation.csv")
    assert metadata["steps_taken"] == SHORT["n_steps"]
    assert metadata["step"] == scores["step"][scores["distance"].idxmin()]
    assert scores["n_faults"].tolist() == [0, *[1] * 7]
    if metadata["step"] > 10:
        assert metadata["collapse"].startswith(f"step {metadata['step']}: mask ignored")
        assert "kept all the same" in caplog.text


def test_holding_every_scene_out_is_refused(tmp_path):
    with pytest.raises(ValueError, match="holds 6 train scenes out, there are 6: none is left"):
        train(**arguments(tmp_path / "run", validation={**VALIDATION, "n_scenes": 6}))


def test_a_held_out_scene_that_cannot_be_rendered_is_named(tmp_path):
    scenes = [replace(scene, image=np.full_like(scene.image, 7)) for scene in toy_scenes(6)]
    write_scenes(tmp_path / "scenes.nc", scenes)
    with pytest.raises(ValueError, match=r"scene toy \d: expected a uint8 image .* with contrast"):
        train(**arguments(tmp_path / "run"))


def test_a_width_that_memory_cannot_hold_is_refused_in_one_line(tmp_path):
    # 54 million weights at width 64 are 1.2e13 at 470 times that: 190 TB with gradients and
    # moments.
    with pytest.raises(
        ValueError, match=r"too little memory for a cGAN of width 30000: it needs at least .* GB"
    ):
        train(**arguments(tmp_path / "run", settings={**SETTINGS, "width": 30000, "depth": 8}))
