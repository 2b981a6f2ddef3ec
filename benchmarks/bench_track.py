"""Range lines tracked a second and core, end to end with linking.

``python benchmarks/bench_track.py [MODEL.onnx]`` simulates an echogram of eight annual layers (400
range bins, 2048 range lines, 16 looks), and prints lines a second of processor time of one thread,
in all and by stage, for the weights as they are, quantised to 8 bits, and averaged with those of
the mirrored echogram. Fails below 5000 lines a second.
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


def quantised(path, temperature):
    """The same network in 8-bit integers, or None where the package onnx is missing."""
    try:
        from onnxruntime.quantization import QuantType, quantize_dynamic

        with tempfile.TemporaryDirectory() as folder:
            small = Path(folder) / "small.onnx"
            quantize_dynamic(path, small, weight_type=QuantType.QUInt8)
            return runner(small.read_bytes(), temperature)
    except Exception as error:  # of whatever kind: this is an aside
        print(f"int8: {type(error).__name__} {error}")  # noqa: T201
        return None


def main():
    """Print the table."""
    warnings.simplefilter("ignore")
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else shipped_trackers()["universal"]
    weights, card = read_tracker(path)
    card = checked_card(card, path)
    echogram = draw_echogram()
    plain = runner(weights, card.temperature)
    small = quantised(path, card.temperature)
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
