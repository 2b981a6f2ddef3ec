"""Fixtures for the tests of files."""

import formats
import pytest

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
def table(flight):
    """Table of the frames in the folder `flight`."""
    return read_frames(flight / "frames.tsv")
