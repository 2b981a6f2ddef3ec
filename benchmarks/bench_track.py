"""Range lines tracked a second and core, end to end with linking.

``python benchmarks/bench_track.py [MODEL.onnx]`` simulates an echogram of eight annual layers (400
range bins, 2048 range lines, 16 looks), and prints lines a second of processor time of one thread,
in all and by stage, for the weights as they are, with stages 1 to 4 in 8-bit integers, and averaged
with those of the mirrored echogram. Fails below 5000 lines a second.
"""

import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np

from snowsim import Climate, Radar, simulate
from snowsim.io.models import read_tracker, shipped_trackers
from snowsim.tracker import canonical, checked_card, evidence_of, layers_of_frames, runner
from snowsim.tracker.windows import to_input

SEED, N_LINES, N_BINS, N_ROUNDS = 1000, 2048, 400, 5
LEAST = 5000


def draw_echogram():
    """An echogram of annual snow, cut to 400 range bins."""
    radar = Radar.preset("snow-2012", n_looks=16)
    snow = Climate(accumulation_m=0.5, n_years=8)
    echogram, _ = simulate(snow, radar, n_range_lines=N_LINES, rng=SEED)
    return echogram.isel(twtt=slice(N_BINS))


def time_stages(run, card, echogram):
    """Processor seconds of the canonical input, the network with its peaks, and linking."""
    times = [time.process_time()]
    seen = canonical(echogram, card)
    times.append(time.process_time())
    evidence = evidence_of(run, seen, card)
    times.append(time.process_time())
    layers_of_frames([evidence], card)
    times.append(time.process_time())
    return np.diff(times)


def mirrored(run):
    """The same network, averaged with what it says of the mirrored input."""

    def both(images):
        back = run(np.ascontiguousarray(images[..., ::-1]))[..., ::-1]
        return (run(images) + back) / 2

    return both


def quantised(path, temperature, images):
    """The network with stages 1 to 4 in 8-bit integers, whose ranges are those of some images.

    None where the package onnx is missing. Of every convolution in integers, little is detected.
    """
    try:
        import onnx
        from onnxruntime import quantization
    except ImportError as error:
        print(f"int8: {error}")  # noqa: T201
        return None
    graph = onnx.load(path).graph
    users = {name: node for node in graph.node for name in node.input}
    nodes = []
    for node in graph.node:
        weights = node.input[1] if node.op_type == "Conv" else ""
        while "stages" in weights and "stages.0" not in weights:
            nodes.append(node.name)
            node = users[node.output[0]]
            if node.op_type not in ("Relu", "MaxPool"):
                break

    class Images(quantization.CalibrationDataReader):
        def __init__(self):
            self.left = iter([{"image": image} for image in images])

        def get_next(self):
            return next(self.left, None)

    with tempfile.TemporaryDirectory() as folder:
        small = Path(folder) / "small.onnx"
        quantization.quantize_static(
            path,
            small,
            Images(),
            nodes_to_quantize=nodes,
            per_channel=True,
            activation_type=quantization.QuantType.QUInt8,  # processors multiply by signed weights
        )
        return runner(small.read_bytes(), temperature)


def main():
    """Print the table."""
    warnings.simplefilter("ignore")
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else shipped_trackers()["universal"]
    weights, card = read_tracker(path)
    card = checked_card(card, path)
    echogram = draw_echogram()
    plain = runner(weights, card.temperature)
    seen = canonical(echogram, card)
    some = [to_input(seen.image(first, first + 256)) for first in (0, N_LINES // 2)]
    small = quantised(path, card.temperature, some)
    runs = {"float32": plain, "float32, mirrored": mirrored(plain), "int8": small}
    best = {}
    for name, run in runs.items():
        if run is None:
            continue
        time_stages(run, card, echogram)  # compiles
        stages = np.min([time_stages(run, card, echogram) for _ in range(N_ROUNDS)], axis=0)
        best[name] = N_LINES / stages.sum()
        parts = ", ".join(f"{1e6 * part / N_LINES:.0f}" for part in stages)
        print(f"{name:<20} {best[name]:6.0f} lines/s (us a line: {parts})")  # noqa: T201
    if best["float32"] < LEAST:
        sys.exit(f"expected {LEAST} lines a second at least")


if __name__ == "__main__":
    main()
