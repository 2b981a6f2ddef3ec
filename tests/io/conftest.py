"""Fixtures for the tests of files."""

from dataclasses import replace

import formats
import numpy as np
import pytest
from toy_scenes import toy_scene

from snowsim.io import read_frames


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
        drawn = toy_scene(number, height, 256, 6)
        drawn.layer_bins[5, 201:] += height
        scene = replace(
            drawn,
            name=f"20120330_04_{number + 1:03d}",
            layer_bins=drawn.layer_bins.copy(),
            complete_layer_bins=drawn.layer_bins,
            noise_floor_db=-61.2345678901234,
            maximum_db=float(rng.normal()),
            zone=number,
            notes={"bin_size_s": 2.886e-10},
        )
        scene.layer_bins[2, 40:90] = np.nan
        made.append(scene)
    return made


@pytest.fixture
def table(flight):
    """Table of the frames in the folder `flight`."""
    return read_frames(flight / "frames.tsv")


@pytest.fixture
def rows(table):
    """Rows of that table, as frames are read by them."""
    return list(table.itertuples())
