"""Fixtures for all tests."""

import os
from pathlib import Path

import numpy as np
import pytest
from processes import ROOT
from toy_scenes import toy_scene


def pytest_collection_modifyitems(items):
    """Tests of reruns go first: one worker makes the tiny run while the others take other files."""
    items.sort(key=lambda item: item.path.name != "test_reruns.py")


@pytest.fixture(autouse=True)
def on_a_gpu(request):
    """Tests marked `gpu` skip where there is none."""
    if request.node.get_closest_marker("gpu") is not None:
        torch = pytest.importorskip("torch")
        if not torch.cuda.is_available():
            pytest.skip("no GPU that torch can use")


@pytest.fixture
def rng():
    return np.random.default_rng(20120429)


@pytest.fixture
def layer_bins():
    """Eight wavy layers on 120 range lines, 12 to 18 bins apart."""
    return toy_scene(1, 320, 120, 8).layer_bins


@pytest.fixture(scope="session")
def shared_data():
    """Folder of files no one in this project wrote; tests that need it skip where it is not."""
    folder = Path(os.environ.get("SNOWSIM_TEST_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no third-party test files: {folder} is no folder (set SNOWSIM_TEST_DATA)")
    return folder


@pytest.fixture(scope="session")
def planted():
    from planted import Planted

    return Planted()


@pytest.fixture(scope="session")
def flight(planted):
    return planted.flight(np.random.default_rng(20120429))
