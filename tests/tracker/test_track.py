import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal

from snowsim.tracker import Settings, Training, track, trained_network

SETTINGS = Settings(width=2)


@pytest.fixture(scope="module")
def network():
    return Training(SETTINGS, seed=1).network


def test_a_network_read_back_tracks_the_same_and_half_precision_nearly(network, rng):
    image = rng.integers(0, 256, (60, 40), dtype=np.uint8)
    weights = {name: value.numpy().copy() for name, value in network.state_dict().items()}
    assert_array_equal(track(trained_network(weights, SETTINGS), image), track(network, image))
    # bfloat16 keeps 8 bits; 13 layers and a slope of 1/4 of the sigmoid on logits below 0.1.
    assert_allclose(track(network, image, precision="bfloat16"), track(network, image), atol=2e-3)


@pytest.mark.parametrize("image", [np.full((20, 10), 9, np.uint8), np.ones((20, 10))])
def test_images_that_are_none_are_refused(network, image):
    with refusal("image must be uint8 .* with contrast"):
        track(network, image)
