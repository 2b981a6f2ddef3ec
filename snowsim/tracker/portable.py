"""The network as ONNX, which runs without torch, and read back."""

import copy
import io
import warnings

import onnx
import torch
from onnx import numpy_helper
from torch import nn

from snowsim.tracker.network import MultiScaleNetwork
from snowsim.training import load_weights

INPUT = "image"
OUTPUT = "logit"
# That the export is traced with; any other goes, too.
TRACED_SHAPE = (1, 1, 64, 48)
PREFIX = "network."  # of names of weights


class FusedLogits(nn.Module):
    """The fused output of a network alone, logits (patch, 1, range_bin, range_line)."""

    def __init__(self, network):
        super().__init__()
        self.network = network

    def forward(self, image):
        """Fused logits of images as from `MultiScaleNetwork.to_input`."""
        return self.network(image)[-1]


def to_onnx(network, offset=0.0):
    """A `MultiScaleNetwork` as ONNX (bytes): the same network always gives the same bytes.

    Input ``image``, float32 (n, 1, range_bin, range_line) of any size: ``2 / 255 * grey - 1`` of an
    image of uint8, as `snowsim.patches.to_signed`. Output ``logit``, of the same shape: the fused
    logits less `offset`, which the bias of the fuse takes in.
    """
    sizes = {0: "n", 2: "range_bin", 3: "range_line"}
    content = io.BytesIO()
    network = copy.deepcopy(network).cpu().eval()
    with torch.no_grad():
        network.fuse.bias -= offset
    with warnings.catch_warnings():
        # The exporter that scripts a network is old, but the new one fixes sizes.
        warnings.simplefilter("ignore")
        torch.onnx.export(
            FusedLogits(network),
            (torch.zeros(TRACED_SHAPE),),
            content,
            dynamo=False,
            do_constant_folding=False,
            input_names=[INPUT],
            output_names=[OUTPUT],
            dynamic_axes={INPUT: sizes, OUTPUT: sizes},
        )
    return content.getvalue()


def network_of_onnx(content):
    """The `MultiScaleNetwork` in what `to_onnx` gave (bytes); its bias holds the offset.

    ValueError where this is no such network.
    """
    try:
        model = onnx.load_model_from_string(content)
    except Exception as error:  # of protobuf, which has several
        msg = f"expected a network as ONNX, cannot be read: {error}"
        raise ValueError(msg) from error
    held = {each.name: numpy_helper.to_array(each).copy() for each in model.graph.initializer}
    n_averaged = 1
    for node in model.graph.node:
        # Weights that are equal are kept once.
        if node.op_type == "Identity" and node.input[0] in held:
            held[node.output[0]] = held[node.input[0]]
        if node.op_type == "AveragePool":
            sizes = {each.name: each.ints for each in node.attribute}
            n_averaged = sizes["kernel_shape"][1]
    expected = MultiScaleNetwork(1).state_dict().keys()
    weights = {name: held[PREFIX + name] for name in expected if PREFIX + name in held}
    # Of a file without weights, a network of one channel, which they do not fit.
    width = len(weights.get("stages.0.0.bias", [0]))
    network = MultiScaleNetwork(width, n_averaged)
    load_weights(network, weights, "tracker")
    return network.eval()
