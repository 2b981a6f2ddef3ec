"""A tracker without training: its one convolution answers to bright ridges, whatever they are."""

import hashlib
import json

import formats
import numpy as np
from onnx import TensorProto, helper, numpy_helper

from lib.placeholder_frames import placeholder_frame

BIN_S = 2.886e-10
SPACING_M = 5.2
METRES_PER_DEGREE = 111_194.9
SEGMENT = "20120330_04"
SURFACE_BIN = 80
LAYER_BINS = SURFACE_BIN + np.array([0, 40, 75, 120, 180])
NAMES = ["surface", "snow_1", "snow_2", "snow_3", "snow_4"]
CARD = {
    "name": "ridges",
    "version": "1",
    "format": "snowsim tracker 1",
    "bin_s": BIN_S,
    "line_spacing_m": SPACING_M,
    "temperature": 1.0,
    "threshold": 0.5,
    "ranges": {"bin_s": [1e-10, 5e-10]},
}


WRITERS = {
    "mat5": (f"Data_{SEGMENT}_001.mat", formats.write_mat5),
    "mat73": (f"Data_{SEGMENT}_001.mat", formats.write_mat73),
    "nsidc": (f"IRSNO1B_{SEGMENT}_001.nc", formats.write_nsidc),
    "opr": (f"Data_{SEGMENT}_001.nc", lambda path, c: formats.opr_dataset(c).to_netcdf(path)),
}


def ridge_weights():
    """ONNX bytes: mean over 5 lines of a row and its neighbours less rows farther off, scaled."""
    profile = np.array([-2, -2, 0, 2, 4, 2, 0, -2, -2], dtype=np.float32)
    kernel = np.repeat(profile[:, None] / profile.size, 5, axis=1) / 5
    image = helper.make_tensor_value_info("image", TensorProto.FLOAT, ["n", 1, "r", "l"])
    logit = helper.make_tensor_value_info("logit", TensorProto.FLOAT, ["n", 1, "r", "l"])
    arrays = {"kernel": 20 * kernel[None, None], "offset": np.array([-1.5], dtype=np.float32)}
    tensors = [numpy_helper.from_array(array, name) for name, array in arrays.items()]
    node = helper.make_node("Conv", ["image", *arrays], ["logit"], pads=[4, 2, 4, 2])
    graph = helper.make_graph([node], "ridges", [image], [logit], tensors)
    opset = [helper.make_opsetid("", 13)]
    return helper.make_model(graph, opset_imports=opset, ir_version=8).SerializeToString()


def write_weights(folder, weights, **changes):
    """Weights and their card in a folder; the path of the weights."""
    path = folder / "ridges.onnx"
    path.write_bytes(weights)
    digest = hashlib.sha256(weights).hexdigest()
    path.with_suffix(".json").write_text(json.dumps(CARD | {"sha256": digest} | changes))
    return path


def planted(rng, *, n_bins=400, n_lines=300, bin_s=BIN_S, spacing_m=SPACING_M, contrast=20.0):
    """Echogram and layers, rolling like a swell: noise of 16 looks, and a bright ridge at each.

    Sizes are in units of the tracker's bins and lines, whatever those of the echogram are.
    """
    bins = np.arange(round(n_bins * BIN_S / bin_s)) * bin_s / BIN_S
    lines = np.arange(round(n_lines * SPACING_M / spacing_m)) * spacing_m / SPACING_M
    swell = 6 * np.sin(2 * np.pi * lines / 150)
    layers = LAYER_BINS[:, None] + swell
    ridges = np.exp(-0.5 * ((bins[:, None] - layers[:, None, :]) / 1.3) ** 2)
    heights = contrast * np.array([10, 1, 1, 1, 1])
    snow = 1 / (1 + np.exp(-(bins[:, None] - layers[0])))
    mean = 1 + 2 * snow + np.tensordot(heights, ridges, 1)
    power = (mean * rng.gamma(16, 1 / 16, mean.shape)).astype(np.float32)
    latitude = 70 + lines * SPACING_M / METRES_PER_DEGREE
    echogram, picks = placeholder_frame(power, layers * BIN_S / bin_s, latitude, bin_s=bin_s)
    # The surface of both is one array.
    picks = picks.copy(deep=True)
    # At 130 m/s.
    slow_time = np.datetime64("2012-01-01", "ns") + (4e7 * lines).astype("timedelta64[ns]")
    return tuple(each.assign_coords(slow_time=slow_time) for each in (echogram, picks))


def content_of(echogram, lines=slice(None)):
    """Content of an L1B file, with the times of the test files' day."""
    number = np.arange(echogram.sizes["slow_time"])[lines]
    gps_time = formats.GPS_START + 0.0437 * number
    return formats.content_of(echogram.isel(slow_time=lines), gps_time, 3e-6)
