"""Fixtures for the tests of files."""

import formats
import pytest


@pytest.fixture
def content(rng):
    """What an L1B file holds."""
    return formats.truth(rng)


@pytest.fixture
def path(tmp_path):
    """A file to write; its name says nothing of its format."""
    return tmp_path / "frame"
