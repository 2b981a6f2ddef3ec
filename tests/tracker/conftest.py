"""A tracker that finds ridges, and a frame that has some."""

import onnx
import pytest
from planted_layers import planted, ridge_weights, write_weights

from snowsim.tracking import Tracker


@pytest.fixture(scope="session")
def weights(tmp_path_factory):
    onnx.checker.check_model(onnx.load_from_string(ridge_weights()))
    return write_weights(tmp_path_factory.mktemp("weights"), ridge_weights())


@pytest.fixture(scope="session")
def tracker(weights):
    return Tracker.load(weights)


@pytest.fixture
def frame(rng):
    """Echogram and layers of `planted`."""
    return planted(rng)
