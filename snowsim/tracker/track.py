"""Layer probabilities of an echogram with a trained tracker."""

import numpy as np
import torch

from snowsim.tracker.network import NETWORKS
from snowsim.training import arithmetic, load_weights


def track(network, image, *, precision="float32"):
    """Probability of a layer in each pixel, by each output of the network.

    Parameters
    ----------
    network : MultiScaleNetwork, PublishedNetwork or LightNetwork
    image : ndarray of uint8, (range_bin, range_line)
        Any size; ValueError unless it has contrast.
    precision : str
        Arithmetic, `float32` or `bfloat16`.

    Returns
    -------
    ndarray of float32, (output, range_bin, range_line)
        In [0, 1]; `OUTPUTS`: side outputs 1 to 5, then the fuse.
    """
    image = np.asarray(image)
    if image.dtype != np.uint8 or image.ndim != 2:
        msg = f"image must be uint8 (range_bin, range_line), got {image.dtype} of shape {image.shape}"
        raise ValueError(msg)
    if image.size == 0 or image.min() == image.max():
        msg = f"image without contrast, of shape {image.shape}"
        raise ValueError(msg)
    device = next(network.parameters()).device
    with torch.inference_mode(), arithmetic(device, precision):
        logits = network(network.to_input(image[None]).to(device))
        return torch.sigmoid(logits[:, 0, 0].float()).cpu().numpy()


def trained_network(weights, settings, *, device="cpu"):
    """Network for `track`, of weights (dict of arrays) and the `Settings` they were trained with."""
    network = NETWORKS[settings.network](settings.width)
    load_weights(network, weights, "tracker")
    return network.to(device=device, memory_format=torch.channels_last).eval()
