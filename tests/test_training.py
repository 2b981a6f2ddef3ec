"""Trainings of both networks repeat and resume to the byte, and refuse what is not theirs."""

from dataclasses import asdict, replace
from itertools import islice

import pytest
import torch
from trainings import begun, same, trained

from snowsim import cgan, tracker
from snowsim.io.models import read_model, write_model
from snowsim.training import arithmetic

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


@ALL
def test_the_same_seed_gives_the_same_bytes_and_another_seed_does_not(settings):
    first, again, other = (trained(settings, seed)[0].state() for seed in (1, 1, 2))
    assert same(first, again)
    assert not same(first, other)


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


def test_a_training_that_diverges_says_so():
    with pytest.raises(FloatingPointError, match="diverged at step"):
        trained(replace(TRACKER, n_steps=50, learning_rate=1e30))


@pytest.mark.parametrize(
    ("settings", "network", "trained_network"),
    [
        (CGAN, "generator", cgan.trained_generator),
        (TRACKER, "tracker", tracker.trained_network),
    ],
)
def test_a_state_of_other_settings_is_refused_in_one_line(settings, network, trained_network):
    state = begun(replace(settings, width=5))[0].state()
    with pytest.raises(
        ValueError, match=f"{network}: expected .* of shape .*, got .*: other settings"
    ) as error:
        begun(settings)[0].restore(state, 1)
    assert "\n" not in str(error.value)
    with pytest.raises(ValueError, match=f"{network}: expected"):
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
