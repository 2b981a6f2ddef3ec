"""Fixtures for the tests of files."""

import formats
import numpy as np
import pytest

from snowsim.echogram import Scene
from snowsim.io.frame_table import read_frames


@pytest.fixture
def content(rng):
    """What an L1B file holds."""
    return formats.truth(rng)


@pytest.fixture
def path(tmp_path):
    """A file to write; its name says nothing of its format."""
    return tmp_path / "frame"


@pytest.fixture
def scenes(rng):
    """Three scenes: fractional layers, gaps, a layer that leaves the window."""
    made = []
    for number, height in enumerate((300, 320, 301)):
        lines = np.arange(256)
        bins = (
            50 + 30.3 * np.arange(6)[:, None] + 4 * np.sin(lines / 40) * np.arange(6)[:, None] / 5
        )
        bins[5] += np.where(lines > 200, height, 0)
        complete = bins.copy()
        bins[2, 40:90] = np.nan
        image = rng.integers(0, 256, size=(height, 256), dtype=np.uint8)
        contrast = {
            "noise_floor_db": -61.2345678901234,
            "maximum_db": float(rng.normal()),
            "zone": number,
        }
        name, notes = f"20120330_04_{number + 1:03d}", {"bin_size_s": 2.886e-10}
        made.append(Scene(name, height, bins, image, complete, **contrast, notes=notes))
    return made


@pytest.fixture
def table(flight):
    """Table of the frames in the folder `flight`."""
    return read_frames(flight / "frames.tsv")


@pytest.fixture
def rows(table):
    """Rows of that table, as frames are read by them."""
    return list(table.itertuples())
