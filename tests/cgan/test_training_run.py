"""A training through its script survives kill -9, and what it leaves on disk is checked when it is taken up again."""

import os
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
import train_cgan
from toy_scenes import toy_scenes
from train_cgan import train

from lib import cgan_training
from lib.training import TrainingRun, Validation, check_memory, enough_memory
from snowsim.io.files import read_table
from snowsim.io.models import read_model
from snowsim.io.scenes import SceneSet, write_scenes

ROOT = Path(__file__).resolve().parents[2]
SMALL = {"width": 2, "depth": 4, "n_strided": 1, "n_range_bins": 64, "n_range_lines": 64, "precision": "float32"}
SETTINGS = {**SMALL, "n_steps": 240}
EVERY_STEPS = 20
# Runs the script in a process of its own and tells every step it has taken.
CHILD = """
import sys, train_cgan
def told(training, scenes, steps=train_cgan.train_steps):
    for step, losses in steps(training, scenes):
        print(step, flush=True)
        yield step, losses
train_cgan.train_steps = told
train_cgan.train(**eval(sys.argv[1]))
"""


def arguments(folder, **changes):
    """Arguments of the script, its files in `folder`, its scenes beside it."""
    scenes = folder.parent / "scenes.nc"
    if not scenes.exists():
        write_scenes(scenes, toy_scenes(6))
    return {
        "scenes": [str(scenes)],
        "generator": str(folder / "generator.safetensors"),
        "losses": str(folder / "losses.csv"),
        "scores": str(folder / "validation.csv"),
        "samples": str(folder / "samples.nc"),
        "seed": 1,
        "device": "cpu",
        "settings": SETTINGS,
        "statistics": "scene",
        "validation": {"n_scenes": 2, "every_steps": 50, "by": "psnr", "patience": None},
        "on_collapse": "fail",
        "source": "no",
        "checkpoint": str(folder / "unfinished.safetensors"),
        "checkpoint_steps": EVERY_STEPS,
        "events": str(folder / "events"),
        **changes,
    }


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Folder of an uninterrupted training."""
    folder = tmp_path_factory.mktemp("trained") / "whole"
    train(**arguments(folder))
    return folder


def test_a_training_killed_midway_ends_with_the_bytes_of_an_uninterrupted_one(whole):
    killed = whole.parent / "killed"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "workflow/scripts")])}
    command = [sys.executable, "-c", CHILD, repr(arguments(killed))]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as child:
        for line in child.stdout:
            if int(line) >= 3.5 * EVERY_STEPS:
                child.send_signal(signal.SIGKILL)
                break
        last_told = max([int(line), *map(int, child.stdout.read().split())])
    assert child.returncode == -signal.SIGKILL
    assert not (killed / "generator.safetensors").exists()
    _, metadata = read_model(killed / "unfinished.safetensors")
    assert 3 * EVERY_STEPS <= metadata["step"] < SETTINGS["n_steps"]
    assert last_told - metadata["step"] <= EVERY_STEPS  # one interval lost at most
    train(**arguments(killed))
    for name in ("generator.safetensors", "losses.csv", "validation.csv", "samples.nc"):
        assert (killed / name).read_bytes() == (whole / name).read_bytes()
    assert len(read_table(killed / "losses.csv")) == SETTINGS["n_steps"]
    assert read_table(killed / "validation.csv")["step"].tolist() == [50, 100, 150, 200, 240]
    assert not list(whole.parent.glob("*/unfinished*"))


def test_the_weights_written_are_those_of_the_best_validation(whole):
    scores = read_table(whole / "validation.csv")
    _, metadata = read_model(whole / "generator.safetensors", {"kind": "cgan generator", "collapse": None})
    assert metadata["step"] == scores["step"][scores["psnr"].idxmax()]
    assert metadata["steps_taken"] == SETTINGS["n_steps"]


def test_sample_sheets_hold_each_scene_as_observed_and_as_rendered_at_every_validation(whole):
    with SceneSet(whole / "samples.nc") as samples:
        sheets = [(sample.name, sample.notes["step"]) for sample in samples]
        observed = {scene.name: scene for scene in toy_scenes(6)}
        assert all((s.image == observed[s.name].image).all() == (s.notes["step"] is None) for s in samples)
    names = sorted({name for name, _ in sheets})
    assert len(names) == 2
    assert sorted(sheets, key=str) == sorted(
        [(name, step) for name in names for step in (None, 50, 100, 150, 200, 240)], key=str
    )


@pytest.fixture
def collapse_after(monkeypatch):
    """Plant a fault in every validation from a step on."""

    def plant(step):
        def measured(generator, scenes, **options):
            return {"mask_response": 0.0 if judges[-1].training.step >= step else 1.0}

        class Watched(cgan_training.Judge):
            def __init__(self, *arguments, **options):
                super().__init__(*arguments, **options)
                judges.append(self)

        judges = []
        monkeypatch.setattr(cgan_training, "WINDOW_STEPS", 20)
        monkeypatch.setattr(cgan_training, "measure_losses", lambda losses, adversarial: {})
        monkeypatch.setattr(cgan_training, "measure_renders", measured)
        monkeypatch.setattr(train_cgan, "Judge", Watched)

    return plant


SHORT = {**SETTINGS, "n_steps": 80, "n_range_bins": 32, "n_range_lines": 32, "depth": 3}
OFTEN = {"n_scenes": 2, "every_steps": 10, "by": "psnr", "patience": None}


def test_a_collapse_says_so_and_fails(tmp_path, collapse_after):
    collapse_after(45)
    with pytest.raises(ValueError, match=r"cGAN training collapsed at step 60: mask ignored") as error:
        train(**arguments(tmp_path / "run", settings=SHORT, validation=OFTEN))
    assert "\n" not in str(error.value)
    assert [path.name for path in (tmp_path / "run").iterdir()] == ["events"]


def test_a_collapse_falls_back_to_the_last_good_weights_and_states_it(tmp_path, collapse_after, caplog):
    collapse_after(45)
    with caplog.at_level("WARNING", logger="snowsim"):
        train(**arguments(tmp_path / "run", settings=SHORT, validation=OFTEN, on_collapse="fall_back"))
    _, metadata = read_model(tmp_path / "run/generator.safetensors")
    assert metadata["collapse"].startswith("step 60: mask ignored")
    assert metadata["step"] <= 40
    assert f"the weights after step {metadata['step']} are kept" in caplog.text
    assert read_table(tmp_path / "run/validation.csv")["step"].tolist() == [10, 20, 30, 40, 50]


def test_a_collapse_before_any_good_weights_fails_whatever_the_setting(tmp_path, collapse_after):
    collapse_after(0)
    rarely = {**OFTEN, "every_steps": 40}  # from step 20 on losses are judged: no weights count as good
    with pytest.raises(ValueError, match="collapsed at step 80"):
        train(**arguments(tmp_path / "run", settings=SHORT, validation=rarely, on_collapse="fall_back"))


def test_a_collapse_that_goes_on_keeps_the_best_and_states_its_faults(tmp_path, collapse_after, caplog):
    collapse_after(0)
    with caplog.at_level("WARNING", logger="snowsim"):
        train(**arguments(tmp_path / "run", settings=SHORT, validation=OFTEN, on_collapse="go_on"))
    _, metadata = read_model(tmp_path / "run/generator.safetensors")
    scores = read_table(tmp_path / "run/validation.csv")
    assert metadata["steps_taken"] == SHORT["n_steps"]
    assert metadata["step"] == scores["step"][scores["psnr"].idxmax()]
    assert scores["n_faults"].tolist() == [0, *[1] * 7]
    if metadata["step"] > 10:
        assert metadata["collapse"].startswith(f"step {metadata['step']}: mask ignored")
        assert "kept all the same" in caplog.text


def test_setting_every_scene_aside_is_refused(tmp_path):
    everything = {"n_scenes": 6, "every_steps": 50, "by": "psnr", "patience": None}
    with pytest.raises(ValueError, match="sets 6 train scenes aside, there are 6: none is left"):
        train(**arguments(tmp_path / "run", validation=everything))


def test_a_scene_set_aside_that_cannot_be_rendered_is_named(tmp_path):
    scenes = [replace(scene, image=np.full_like(scene.image, 7)) for scene in toy_scenes(6)]
    write_scenes(tmp_path / "scenes.nc", scenes)
    with pytest.raises(ValueError, match=r"scene toy \d: image without contrast, every pixel is 7"):
        train(**arguments(tmp_path / "run"))


def test_a_width_that_memory_cannot_hold_is_refused_in_one_line(tmp_path):
    # 54 million weights at width 64 are 1.2e13 at 470 times that: 190 TB with gradients and moments.
    with pytest.raises(ValueError, match=r"too little memory for a cGAN of width 30000: it needs at least .* GB"):
        train(**arguments(tmp_path / "run", settings={**SETTINGS, "width": 30000, "depth": 8}))


class Counter:
    """A training that counts: what it has added up is all its state."""

    def __init__(self, fails_after=None):
        self.step, self.total, self.fails_after = 0, 0.0, fails_after

    def state(self):
        return {"total": torch.tensor([self.total], dtype=torch.float64)}

    def restore(self, state, step):
        self.step, self.total = step, float(state["total"][0])

    def steps(self, n):
        while self.step < n:
            if self.step == self.fails_after:
                raise KeyboardInterrupt
            self.step += 1
            self.total += 1 / self.step
            yield self.step, {"zeta": self.total, "alpha": 1 / self.step}


def counted(path, counter, n_steps=50, made_of=7, patience=None):
    """The run of a counter that is best at step 23 or, of those validated, at 20."""
    validation = Validation(
        every_steps=10,
        score=lambda: {"near": -abs(counter.step - 23.0), "also": counter.total},
        weights=lambda: counter.state(),
        by="near",
        patience=patience,
    )
    with TrainingRun(counter, path, {"made_of": made_of}, every_steps=7, validation=validation) as run:
        run.take(counter.steps(n_steps), n_steps, "counter")
    return run


def test_losses_scores_and_the_best_survive_an_interruption(tmp_path):
    path = tmp_path / "unfinished.safetensors"
    whole = counted(tmp_path / "other.safetensors", Counter())
    with pytest.raises(KeyboardInterrupt):
        counted(path, Counter(fails_after=38))
    resumed = counted(path, Counter())
    assert list(resumed.losses().columns) == ["step", "zeta", "alpha"]
    assert resumed.losses().equals(whole.losses())
    assert resumed.scores().equals(whole.scores())
    assert resumed.scores()["step"].tolist() == [10, 20, 30, 40, 50]
    assert whole.best_step == resumed.best_step == 20
    assert resumed.best["total"] == whole.best["total"] == sum(1 / n for n in range(1, 21))
    assert not path.exists()


def test_a_training_stops_when_validation_brings_nothing_better(tmp_path):
    run = counted(tmp_path / "unfinished.safetensors", Counter(), n_steps=500, patience=3)
    assert run.has_stalled
    assert run.losses()["step"].iloc[-1] == 50  # best at 20, none better at 30, 40 and 50
    assert run.best_step == 20


@pytest.fixture
def unfinished(tmp_path):
    path = tmp_path / "unfinished.safetensors"
    with pytest.raises(KeyboardInterrupt):
        counted(path, Counter(fails_after=15))
    return path


def test_a_checkpoint_of_another_configuration_is_refused_in_one_line(unfinished):
    with pytest.raises(ValueError, match=r"made_of: expected 8, got 7: another .*: remove it to begin anew") as error:
        counted(unfinished, Counter(), made_of=8)
    assert "\n" not in str(error.value)
    assert unfinished.exists()


@pytest.mark.parametrize("kept", [0, 5, 100, -1])
def test_a_truncated_checkpoint_is_refused_in_one_line(unfinished, kept):
    unfinished.write_bytes(unfinished.read_bytes()[:kept])
    with pytest.raises(ValueError, match=r"unfinished.safetensors: expected a whole .*remove it") as error:
        counted(unfinished, Counter())
    assert "\n" not in str(error.value)


def test_events_are_written_for_tensorboard(tmp_path):
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    counter = Counter()
    with TrainingRun(counter, tmp_path / "u.safetensors", {}, every_steps=50, path_to_events=tmp_path / "e") as run:
        run.take(counter.steps(30), 30, "counter")
    events = EventAccumulator(str(tmp_path / "e"))
    events.Reload()
    assert [event.step for event in events.Scalars("loss/alpha")] == [10, 20, 30]
    np.testing.assert_allclose([event.value for event in events.Scalars("loss/alpha")], [1 / 10, 1 / 20, 1 / 30])


def test_too_little_memory_is_one_line():
    with pytest.raises(ValueError, match=r"too little memory for a network: it needs at least 1e\+09 GB"):
        check_memory(1e18, "a network")
    check_memory(1, "a number")
    with pytest.raises(ValueError, match="too little memory for a tensor: ") as error, enough_memory("a tensor"):
        torch.empty(1 << 60, dtype=torch.uint8)
    assert "\n" not in str(error.value)
    with pytest.raises(RuntimeError, match="shape"), enough_memory("a tensor"):
        torch.ones(2).reshape(3)
