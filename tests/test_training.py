"""Trainings of both networks repeat and resume to the byte, and refuse what is not theirs."""

from dataclasses import asdict, replace
from itertools import islice

import numpy as np
import pytest
import torch
from refusals import refusal
from toy_scenes import toy_scenes
from trainings import begun, same, trained

from snowsim import cgan, tracker
from snowsim.io import SceneSet, read_model, write_model, write_scenes
from snowsim.training import READ_EVERY, arithmetic

CGAN = cgan.Settings(width=4, depth=4, n_steps=6, n_range_bins=64, n_range_lines=64)
TRACKER = tracker.Settings(width=2, n_steps=6, n_range_bins=64, n_range_lines=48)
PUBLISHED = tracker.published_settings(n_steps=6, width=2, n_accumulated=4)
PIX2PIX = replace(CGAN, method="pix2pix")
NAMES = {
    "cgan": CGAN,
    "pix2pix": PIX2PIX,
    "tracker": TRACKER,
    "published tracker": PUBLISHED,
}
ALL = pytest.mark.parametrize("settings", NAMES.values(), ids=NAMES)


@pytest.mark.parametrize("n_before", [4, 5])
@ALL
def test_a_resumed_training_equals_an_uninterrupted_one_to_the_byte(settings, n_before, tmp_path):
    whole, losses = trained(settings)
    broken, steps = begun(settings)
    assert len(list(islice(steps, n_before))) == n_before
    write_model(
        tmp_path / "state.safetensors",
        broken.state(),
        {"step": n_before, "settings": asdict(settings)},
    )
    state, metadata = read_model(
        tmp_path / "state.safetensors", expected={"settings": asdict(settings)}
    )
    resumed, steps = begun(settings)
    resumed.restore(state, metadata["step"])
    assert [later for _, later in steps] == losses[n_before:]
    assert resumed.step == whole.step
    assert same(resumed.state(), whole.state())


@ALL
def test_processes_that_prepare_inputs_change_no_byte_and_another_seed_does(settings, tmp_path):
    write_scenes(tmp_path / "scenes.nc", toy_scenes(3), {"source": "toy"})
    alone, losses = trained(settings)
    with SceneSet(tmp_path / "scenes.nc") as scenes:
        beside, found = trained(settings, scenes=scenes, n_workers=2)
    assert found == losses
    assert same(alone.state(), beside.state())
    assert not same(alone.state(), trained(settings, seed=2)[0].state())


def test_a_scene_that_cannot_be_trained_on_is_refused_in_one_line_whoever_reads_it():
    blank = replace(toy_scenes(1)[0], image=np.zeros((96, 64), dtype=np.uint8))
    for n_workers in (0, 2):
        with refusal(r"^scene toy .*: expected a uint8 image[^\n]*$"):
            trained(TRACKER, scenes=[blank], n_workers=n_workers)


@pytest.mark.gpu
@ALL
def test_captured_steps_change_weights_as_called_ones_do(settings, monkeypatch):
    settings = replace(settings, n_steps=20, precision="float32")
    start = weights_of(begun(settings)[0])
    captured = weights_of(trained(settings, device="cuda")[0])
    monkeypatch.setattr("snowsim.training.MOST_GRAPHS", 0)
    called = weights_of(trained(settings, device="cuda")[0])
    # Kernels differ between captured and called steps in the order of their sums alone.
    apart = (captured - called).norm()
    assert apart < 1e-3 * (called - start).norm()


@pytest.mark.gpu
@ALL
def test_a_training_on_a_gpu_goes_on_from_its_state(settings):
    settings = replace(settings, n_steps=100, precision="float32")
    whole = weights_of(trained(settings, device="cuda")[0])
    broken, steps = begun(settings, device="cuda")
    step, _ = next(steps)
    assert step == READ_EVERY
    resumed, steps = begun(settings, device="cuda")
    resumed.restore(broken.state(), step)
    assert [number for number, _ in steps] == [2 * READ_EVERY]
    moved = (whole - weights_of(begun(settings)[0])).norm()
    # Sums of a GPU are not in the same order every time.
    assert (weights_of(resumed) - whole).norm() < 1e-2 * moved


def weights_of(training):
    """All weights of a training, one vector."""
    state = training.state()
    names = ["network", "generator", "discriminator"]
    networks = [state[name] for name in names if name in state]
    return torch.cat([value.flatten() for network in networks for value in network.values()])


def test_a_training_that_diverges_says_so():
    with pytest.raises(FloatingPointError, match="diverged at step"):
        trained(replace(TRACKER, n_steps=50, learning_rate=1e30))


@pytest.mark.parametrize(
    ("settings", "network", "trained_network"),
    [
        (CGAN, "generator", cgan.trained_generator),
        (TRACKER, "tracker( network)?", tracker.trained_network),
    ],
)
def test_a_state_of_other_settings_is_refused_in_one_line(settings, network, trained_network):
    state = begun(replace(settings, width=5))[0].state()
    with refusal(f"{network}: expected .* of shape .*, got .*: other settings"):
        begun(settings)[0].restore(state, 1)
    with refusal(f"{network}: expected"):
        trained_network({}, settings)


@pytest.mark.parametrize(
    ("capability", "precision", "computed"),
    [
        ("AVX2", "bfloat16", torch.float32),
        ("AVX2", "float32", torch.float32),
        ("AVX512", "bfloat16", torch.bfloat16),
    ],
)
def test_bfloat16_is_computed_in_float32_where_it_is_emulated(
    capability, precision, computed, monkeypatch, recwarn
):
    monkeypatch.setattr(torch.backends.cpu, "get_cpu_capability", lambda: capability)
    with arithmetic("cpu", precision):
        product = torch.ones(2, 2) @ torch.ones(2, 2)
    assert product.dtype == computed
    # Not in silence.
    assert len(recwarn) == (computed is torch.float32 and precision == "bfloat16")
