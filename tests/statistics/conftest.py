"""Planted flights, and the way to the module that plants them."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

from planted import Planted  # noqa: E402


@pytest.fixture(scope="session")
def planted():
    return Planted()


@pytest.fixture(scope="session")
def flight(planted):
    return planted.flight(np.random.default_rng(20120429))
