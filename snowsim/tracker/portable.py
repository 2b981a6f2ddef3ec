"""Networks written to ONNX, which runs without torch, and read from it."""

import copy
import io
import warnings

import onnx
import torch
from onnx import numpy_helper
from torch import nn

from snowsim.tracker.network import MultiScaleNetwork, PyramidNetwork
from snowsim.training import load_weights

INPUT_NAME = "image"
OUTPUT_NAME = "logit"
TRACED_SHAPE = (1, 1, 64, 48)  # image of the export; the exported network takes any size
PREFIX = "network."  # of the names of weights in the file


class FusedLogits(nn.Module):
    """A network that gives only its fused output, logits (patch, 1, range_bin, range_line)."""

    def __init__(self, network):
        super().__init__()
        self.network = network
        network.enlarged = enlarged_alone

    def forward(self, image):
        """Fused logits of images as from `MultiScaleNetwork.to_input`."""
        return self.network(image)[-1]


def enlarged_alone(logit, factors, size):
    """`MultiScaleNetwork.enlarged` in a form that is fast in onnxruntime.

    onnxruntime pads a single channel to sixteen until the channel axis is removed; here it is
    removed before the map is enlarged.
    """
    without_channel = logit.squeeze(1)
    return MultiScaleNetwork.enlarged(without_channel.unsqueeze(1), factors, size)


def to_onnx(network, offset=0.0, about=None):
    """ONNX file (bytes) of a `MultiScaleNetwork`; the same network always gives the same bytes.

    The input ``image``, float32 (n, 1, range_bin, range_line) of any size, is ``2 / 255 * grey -
    1`` of a uint8 image, see `snowsim.patches.to_signed`. The output ``logit``, of the same shape,
    are the fused logits less `offset`, which is subtracted from the bias of the fuse. `about` are
    texts by name for the metadata of the file.
    """
    sizes = {0: "n", 2: "range_bin", 3: "range_line"}
    content = io.BytesIO()
    network = copy.deepcopy(network).cpu().eval()
    with torch.no_grad():
        network.fuse.bias -= offset
    with warnings.catch_warnings():
        # torch warns that this exporter is old, but the new one fixes the size of images.
        warnings.simplefilter("ignore")
        torch.onnx.export(
            FusedLogits(network),
            (torch.zeros(TRACED_SHAPE),),
            content,
            dynamo=False,
            do_constant_folding=False,
            input_names=[INPUT_NAME],
            output_names=[OUTPUT_NAME],
            dynamic_axes={INPUT_NAME: sizes, OUTPUT_NAME: sizes},
        )
    model = onnx.load_model_from_string(content.getvalue())
    onnx.helper.set_model_props(model, about or {})
    return model.SerializeToString(deterministic=True)


def network_of_onnx(content):
    """Network from the bytes that `to_onnx` gave; the offset stays in its bias.

    ValueError if the bytes are no such network.
    """
    try:
        model = onnx.load_model_from_string(content)
    except Exception as error:  # protobuf has several kinds
        msg = f"expected a network as ONNX, cannot be read: {error}"
        raise ValueError(msg) from error
    held = {each.name: numpy_helper.to_array(each).copy() for each in model.graph.initializer}
    n_averaged = 1
    for node in model.graph.node:
        # The file stores equal weights once.
        if node.op_type == "Identity" and node.input[0] in held:
            held[node.output[0]] = held[node.input[0]]
        if node.op_type == "AveragePool":
            sizes = {each.name: each.ints for each in node.attribute}
            n_averaged = sizes["kernel_shape"][1]
    kind = PyramidNetwork if PREFIX + "laterals.0.weight" in held else MultiScaleNetwork
    expected = kind(1).state_dict().keys()
    weights = {name: held[PREFIX + name] for name in expected if PREFIX + name in held}
    # Width 1 for a file without weights: `load_weights` then names the first that is missing.
    width = len(weights.get("stages.0.0.bias", [0]))
    return load_weights(kind(width, n_averaged), weights, "tracker").eval()
