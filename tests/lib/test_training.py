"""A training goes on from what it left on disk, which is checked; missing memory is named."""

import logging

import numpy as np
import pandas as pd
import pytest
import torch
from formats import refused
from refusals import refusal

from lib.cgan_training import note_saturation
from lib.training import TrainingRun, check_memory, enough_memory


class Counter:
    """A training that counts: what it has added up is all its state."""

    def __init__(self, fails_after=None, error=KeyboardInterrupt):
        self.step, self.total, self.fails_after, self.error = 0, 0.0, fails_after, error

    def state(self):
        return {"total": torch.tensor([self.total], dtype=torch.float64)}

    def restore(self, state, step):
        self.step, self.total = step, float(state["total"][0])

    def steps(self, n):
        while self.step < n:
            if self.step == self.fails_after:
                raise self.error
            self.step += 1
            self.total += 1 / self.step
            yield self.step, {"zeta": self.total, "alpha": 1 / self.step}


def counted(path, counter, made_of=7):
    """The run of a counter to 50."""
    kept = {"checkpoint": path, "checkpoint_steps": 7, "events": path.with_name("events")}
    with TrainingRun(counter, {"made_of": made_of}, **kept) as run:
        run.take(counter.steps(50), 50, "counter")
    return run


@pytest.fixture
def unfinished(tmp_path):
    path = tmp_path / "unfinished.safetensors"
    with pytest.raises(KeyboardInterrupt):
        counted(path, Counter(fails_after=15))
    return path


def test_an_interrupted_training_ends_as_one_that_was_left_alone(unfinished, tmp_path):
    whole = counted(tmp_path / "whole.safetensors", Counter())
    # Begun anew it would fail.
    resumed = counted(unfinished, Counter(fails_after=10, error=AssertionError))
    assert resumed.training.total == whole.training.total
    pd.testing.assert_frame_equal(resumed.losses(), whole.losses())
    assert not unfinished.exists()


def test_a_training_that_diverges_leaves_no_checkpoint(unfinished):
    with pytest.raises(FloatingPointError):
        counted(unfinished, Counter(fails_after=20, error=FloatingPointError))
    assert not unfinished.exists()


def test_a_checkpoint_of_another_configuration_is_refused_in_one_line(unfinished):
    message = "made_of: expected 8, found 7: another .*: remove it to begin anew"
    refused(lambda path: counted(path, Counter(), made_of=8), unfinished, message)
    assert unfinished.exists()


def test_too_little_memory_is_one_line():
    with refusal(r"too little memory for a network: it needs at least 1e\+09 GB"):
        check_memory(1e18, "a network")
    check_memory(1, "a number")
    with (
        refusal("too little memory for a tensor: "),
        enough_memory("a tensor"),
    ):
        torch.empty(1 << 60, dtype=torch.uint8)
    with pytest.raises(RuntimeError, match="shape"), enough_memory("a tensor"):
        torch.ones(2).reshape(3)


@pytest.mark.parametrize(("share", "warns"), [(0.05, True), (0.97, False)])
def test_a_saturated_discriminator_is_noted(share, warns, caplog):
    # Early losses count no more.
    share = np.r_[np.full(50, 1 - share), np.full(200, share)]
    loss = share * np.log(2)
    losses = pd.DataFrame({"discriminator_real": 0.5 * loss, "discriminator_fake": 1.5 * loss})
    with caplog.at_level(logging.WARNING):
        note_saturation(losses)
    assert ("discriminator saturated" in caplog.text) == warns
