"""The figure of a real echogram in the documentation shows what the real file gives."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

from snowsim.io.images import read_image

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "benchmarks"))

from accumulation_radar import SNOW_ROWS, describe, draw  # noqa: E402

FRAME = "accumulation_radar_png/20100507_01_008_010_5m_30m_ORIGINAL.png"


@pytest.fixture(scope="module")
def image(shared_data):
    return read_image(shared_data / FRAME)[0]


def test_the_documented_numbers_are_those_of_the_real_file(image):
    found, _ = describe(image)
    documented = pd.read_csv(ROOT / "docs/accumulation_radar.csv")
    assert found["curve"].tolist() == documented["curve"].tolist()
    # Written with 10 digits; float32 sums over 3060 lines may be taken in another order.
    assert_allclose(found["x"], documented["x"], rtol=1e-9)
    assert_allclose(found["value"], documented["value"], rtol=1e-5, atol=1e-7)


def test_its_texture_is_that_of_other_real_firn_echograms(image):
    table, _ = describe(image)
    across = table[table["curve"] == "autocorrelation along track"].set_index("x")["value"]
    # Published for the same kind of data: lag 1 0.63-0.79, lag 10 0.51-0.70, lag 50 0.31-0.57.
    assert 0.63 <= across[1] <= 0.79
    assert 0.51 <= across[10] <= 0.70
    assert 0.31 <= across[50] <= 0.57


def test_its_autocorrelation_equals_a_slow_sum_over_pairs(image):
    table, surface = describe(image)
    rows = surface.astype(int)
    level = np.array([image[row + SNOW_ROWS.start : row + SNOW_ROWS.stop, i] for i, row in enumerate(rows)], float)
    deviation = level - level.mean()
    pairs = [(line[:-5] * line[5:]).sum() for line in deviation]
    expected = np.sum(pairs) / (deviation.shape[0] * (deviation.shape[1] - 5)) / deviation.var()
    down = table[table["curve"] == "autocorrelation in range"].set_index("x")["value"]
    assert_allclose(down[5], expected, rtol=1e-9)


def test_its_surface_is_the_brightest_and_noise_the_darkest(image):
    table, surface = describe(image)
    fall = table[table["curve"] == "fall"].set_index("x")["value"]
    assert fall.idxmax() == 0
    assert abs(fall.loc[-24:-20].mean()) < 1  # [dB] air is where the noise was taken
    assert fall[0] > fall[40] + 6 > fall[-22] + 6
    figure = draw(image, surface, table, "observed")
    assert len(figure.axes) == 4
