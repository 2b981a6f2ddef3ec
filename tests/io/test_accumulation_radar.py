"""The figure of a real echogram in the documentation shows what the real file gives."""

import sys

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

from lib.imports import ROOT
from snowsim.io.images import read_image

sys.path.append(str(ROOT / "benchmarks"))

from accumulation_radar import SNOW_ROWS, describe, draw  # noqa: E402


@pytest.fixture(scope="module")
def described(shared_data):
    """The image, the table of its numbers, their curves by name, and its surface."""
    image = read_image(shared_data / "accumulation_radar_png/20100507_01_008_010_5m_30m_ORIGINAL.png")[0]
    table, surface = describe(image)
    return image, table, {name: curve.set_index("x")["value"] for name, curve in table.groupby("curve")}, surface


def test_the_documented_numbers_are_those_of_the_real_file(described):
    found, documented = described[1], pd.read_csv(ROOT / "docs/accumulation_radar.csv")
    assert found["curve"].tolist() == documented["curve"].tolist()
    # Written with 10 digits; float32 sums over 3060 lines may be taken in another order.
    assert_allclose(found["x"], documented["x"], rtol=1e-9)
    assert_allclose(found["value"], documented["value"], rtol=1e-5, atol=1e-7)


def test_its_texture_is_that_of_other_real_firn_echograms(described):
    across = described[2]["autocorrelation along track"]
    # Published for the same kind of data: lag 1 0.63-0.79, lag 10 0.51-0.70, lag 50 0.31-0.57.
    assert 0.63 <= across[1] <= 0.79
    assert 0.51 <= across[10] <= 0.70
    assert 0.31 <= across[50] <= 0.57


def test_its_autocorrelation_equals_a_slow_sum_over_pairs(described):
    image, _, curves, surface = described
    rows = surface.astype(int)
    level = np.array([image[row + SNOW_ROWS.start : row + SNOW_ROWS.stop, i] for i, row in enumerate(rows)], float)
    deviation = level - level.mean()
    pairs = [(line[:-5] * line[5:]).sum() for line in deviation]
    expected = np.sum(pairs) / (deviation.shape[0] * (deviation.shape[1] - 5)) / deviation.var()
    assert_allclose(curves["autocorrelation in range"][5], expected, rtol=1e-9)


def test_its_surface_is_the_brightest_and_noise_the_darkest(described):
    image, table, curves, surface = described
    fall = curves["fall"]
    assert fall.idxmax() == 0
    assert abs(fall.loc[-24:-20].mean()) < 1  # [dB] air is where the noise was taken
    assert fall[0] > fall[40] + 6 > fall[-22] + 6
    assert len(draw(image, surface, table, "observed").axes) == 4
