"""Cost of the trackers that config/paper.yaml asks for, from a few gradients on the scenes of a finished run.

``python benchmarks/bench_tracker.py RESULTS`` takes an epoch of two real scenes, of two label scenes and of the highest
label scene (10 gradients and an update each) by the published recipe, on a GPU where there is one. It prints seconds a
megapixel and the peak of memory, and what the four trainings would take by their gradients and mean heights.
"""

import logging
import resource
import sys
import time
from pathlib import Path

import numpy as np
import torch
import yaml

from snowsim.io.scenes import SceneSet
from snowsim.tracker import Settings, Training, TrainingSet, train_steps

CONFIG = Path(__file__).parents[1] / "config"
N_REAL, N_ADDED = 2360, {"rd": 0, "rd_gd": 1500, "rd_pd": 1500, "rd_pd_gd": 3000}
N_EPOCH_COPIES = 5

log = logging.getLogger(__name__)


def paper_settings():
    """Settings and epochs of config/paper.yaml; steps for one epoch of two scenes."""
    default, paper = (yaml.safe_load((CONFIG / name).read_text())["tracker"] for name in ("config.yaml", "paper.yaml"))
    steps = {"n_steps": 2 * N_EPOCH_COPIES}
    return Settings(**{**default["training"], **paper["training"], **steps}), paper["n_epochs"]


def time_epoch(name, scenes, settings, device):
    """Seconds a megapixel of an epoch of two scenes."""
    training = Training(settings, seed=1, device=device)
    # On the CPU processor time: other work on the machine does not count.
    clock = time.perf_counter if device == "cuda" else time.process_time
    start = clock()
    for _ in train_steps(training, TrainingSet(scenes, seed=1)):  # reading the losses waits for the device
        pass
    seconds = clock() - start
    if device == "cuda":
        peak = torch.cuda.max_memory_allocated() / 1e9
    else:
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    megapixels = copied_megapixels(sum(scene.n_range_bins for scene in scenes), settings)
    heights = " and ".join(str(scene.n_range_bins) for scene in scenes)
    log.info("%s of %s rows: %.2f s a gradient, %.2f s a megapixel, peak %.2f GB",
             name, heights, seconds / settings.n_steps, seconds / megapixels, peak)  # fmt: skip
    return seconds / megapixels


def copied_megapixels(n_rows, settings):
    """Pixels of all copies of so many rows of 256 range lines."""
    return n_rows * 256e-6 * (sum(scale**2 for scale in settings.scales) + settings.flip)


def project(results):
    settings, n_epochs = paper_settings()
    device = "cuda" if torch.cuda.is_available() else "cpu"
    log.info("width %d, %s, %s, %d threads", settings.width, settings.precision, device, torch.get_num_threads())
    files = {"real": "benchmark/train", "label": "phy/labels"}
    costs, mean_rows = {}, {}
    for kind, folder in files.items():
        with SceneSet(sorted(Path(results, folder).glob("*.nc"))) as scenes:
            rows = np.array([scene.n_range_bins for scene in scenes])
            order = np.argsort(rows)
            mean_rows[kind] = rows.mean()
            middle = [scenes[order[int(share * len(rows))]] for share in (0.25, 0.75)]
            costs[kind] = time_epoch(f"{kind} scenes", middle, settings, device)
            highest = [scenes[order[-1]]] * 2
    time_epoch("highest label scene, twice", highest, settings, device)
    for name, n_added in N_ADDED.items():
        n_gradients = n_epochs * N_EPOCH_COPIES * (N_REAL + n_added)
        seconds = sum(
            n_epochs * n * copied_megapixels(mean_rows[kind], settings) * costs[kind]
            for kind, n in (("real", N_REAL), ("label", n_added))
        )
        log.info("%-8s %d gradients, %d updates, %.1f days", name, n_gradients, n_gradients // 10, seconds / 86400)


if __name__ == "__main__":
    logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stdout)
    torch.set_num_threads(1)
    project(sys.argv[1])
