import numpy as np
import pytest
from flights import BARE_FIRN, BARE_RADAR, climate_of, peak_rows

from reference import draw_scene
from reference import echo as echo_module
from snowsim.echogram import SURFACE_ROW
from snowsim.seeding import random_stream

SHORT_TAILS = {"surface_slope": 0.005, "horizon_slope": 0.005, "diffuse_share": 0.0}
N_LAYERS = 6  # surface and the youngest


@pytest.fixture(scope="module")
def climate():
    return climate_of({"firn": BARE_FIRN, "radar": BARE_RADAR | SHORT_TAILS})


@pytest.fixture
def echoes(monkeypatch):
    """Every `Echo` that frames and scenes draw, as they draw it."""
    kept = []

    def draw_and_keep(*arguments, **options):
        kept.append(draw_echo(*arguments, **options))
        return kept[-1]

    draw_echo = echo_module.draw_echo
    monkeypatch.setattr(echo_module, "draw_echo", draw_and_keep)
    return kept


def test_layers_of_a_scene_lie_where_its_mean_echo_peaks(climate, echoes):
    how = {"climate": climate, "settings": climate.settings, "n_looks": 1}
    scene = draw_scene(1, "test", **how, rng=random_stream(1, "scene"))
    bins = scene.layer_bins[:N_LAYERS]
    assert abs(bins[0].mean() - SURFACE_ROW) < 3
    for line in range(0, 256, 9):
        # The benchmark's echo is cropped for its looks; the record it was drawn from is kept whole.
        assert np.abs(peak_rows(echoes[0], line, bins[:, line]) - bins[:, line]).max() < 0.1
        shifted = bins[:, line] + 0.2  # a shift of a fifth of a bin would be seen
        assert np.abs(peak_rows(echoes[0], line, shifted) - shifted).min() > 0.1
