"""Processor time of ``snowsim track`` from file to file: its start, a range line, and each part.

``python benchmarks/bench_files.py [OTHER]`` simulates a segment of six frames of 1000 range lines
of annual snow (snow-2012) as CReSIS files. It tracks one frame and then all six in a process of
their own; a range line takes the difference of both, by lines, and the start what is left of the
first. With the path of OTHER, a checkout of another version, both take turns. The least of several
rounds is printed, then the parts of a line in one process.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

from snowsim.io import read_echogram
from snowsim.io.layers import rounded, write_layer_files, write_layers
from snowsim.io.models import read_tracker, shipped_trackers
from snowsim.tracker import canonical, checked_card, evidence_of, layers_of_frames, runner
from snowsim.tracking.trackers import layer_names

HERE = Path(__file__).parents[1]
SEGMENT, N_FRAMES, N_LINES, N_ROUNDS = "20120330_04", 6, 1000, 5


def run(root, *arguments):
    """Processor seconds of a command `snowsim` of the checkout at `root`."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-c", "from snowsim.cli import main; main()", *map(str, arguments)]
    environment = os.environ | {"PYTHONPATH": str(root), "OMP_NUM_THREADS": "1"}
    subprocess.run(command, check=True, env=environment, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def time_files(root, frames, folder):
    """Processor seconds of the start, and of a range line from the second frame on."""
    one, all_frames = (
        run(root, "track", *tracked, "-o", folder / f"picked_{len(tracked)}", "--force")
        for tracked in (frames[:1], frames)
    )
    line = (all_frames - one) / ((len(frames) - 1) * N_LINES)
    return one - N_LINES * line, line


def time_parts(path, folder, weights, card):
    """Processor seconds of each part of the tracking of one frame, by name."""
    times = {}
    of_network = 0.0
    network = runner(weights, card.temperature)

    def timed_network(images):
        nonlocal of_network
        begin = time.process_time()
        found = network(images)
        of_network += time.process_time() - begin
        return found

    def take(name, function, *arguments, **options):
        begin = time.process_time()
        result = function(*arguments, **options)
        times[name] = time.process_time() - begin
        return result

    echogram = take("reading", read_echogram, path)
    seen = take("canonical form", canonical, echogram, card)
    evidence = take("image and candidates", evidence_of, timed_network, seen, card)
    times["image and candidates"] -= of_network
    times["network"] = of_network
    (layers,) = take("following layers", layers_of_frames, [evidence], card)
    layers = layers.assign_coords(layer=layer_names(layers["layer"].values))
    layers = take("rounding", rounded, layers)
    take("writing NetCDF", write_layers, folder / "layers.nc", layers, force=True)
    frames = {1: layers}
    take("writing MAT", write_layer_files, folder, SEGMENT, frames, force=True)
    return times


def main():
    """Print the table."""
    warnings.simplefilter("ignore")
    roots = {"this": HERE} | {path: Path(path).resolve() for path in sys.argv[1:2]}
    shipped = shipped_trackers()["universal"]
    weights, card = read_tracker(shipped)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        first = folder / f"Data_{SEGMENT}_001.mat"
        size = ("--range-lines", N_LINES, "--frames", N_FRAMES)
        run(HERE, "simulate", first, "--radar", "snow-2012", *size)
        frames = sorted(folder.glob(f"Data_{SEGMENT}_*.mat"))
        found = {name: [] for name in roots}
        for round_ in range(N_ROUNDS + 1):
            for name, root in roots.items():
                times = time_files(root, frames, folder)
                if round_ > 0:  # the first compiles
                    found[name].append(times)
        for name, times in found.items():
            start, line = map(min, zip(*times, strict=True))
            print(f"{name}: start {start:.2f} s, then {1 / line:.0f} lines a second")  # noqa: T201
        card = checked_card(card, shipped)
        rounds = [time_parts(first, folder, weights, card) for _ in range(N_ROUNDS + 1)][1:]
        for part in rounds[0]:
            least = min(times[part] for times in rounds)
            print(f"{part:<22} {1e6 * least / N_LINES:4.0f} us a line")  # noqa: T201


if __name__ == "__main__":
    main()
