"""Cost of edge scores.

Against the reference's seconds, against sparse assignment, and for a whole Table III.

Run as ``python benchmarks/bench_edges.py``; it prints ratios and fails where one misses its target.
Maps are made here, so no other file is needed.
"""

import logging
import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter, gaussian_filter1d
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components, min_weight_full_bipartite_matching
from scipy.spatial import cKDTree

from snowsim.echogram import layer_mask
from snowsim.io.pairs import write_image
from snowsim.metrics.edges import THRESHOLDS, match_counts, suppress
from snowsim.scoring import score_folders
from snowsim.seeding import random_stream

# py-bsds500 on one core, CPU seconds per image at 99 thresholds (project's own measurement).
REFERENCE_SECONDS = {(128, 256): 5.4, (321, 481): 26.0}
FIRST_CALL = (
    "import time, numpy as np; from snowsim.metrics.edges import *; start = time.perf_counter(); "
    "match_counts(suppress(np.eye(64)), np.eye(64), THRESHOLDS); print(time.perf_counter() - start)"
)
MAX_DIST = 0.0075

log = logging.getLogger(__name__)


def draw_map(shape, n_layers, *, rng):
    """An edge map as of a tracker (fading, displaced, noisy, 3 pixels wide) and its truth."""
    n_rows, n_lines = shape
    wave = gaussian_filter1d(rng.standard_normal((n_layers, n_lines)), 15, axis=1)
    spacing = (
        (n_rows - n_rows // 4) / n_layers * np.abs(1 + 0.3 * rng.standard_normal((n_layers, 1)))
    )
    layer_bins = n_rows / 8 + np.cumsum(np.maximum(spacing + 3 * wave, 2), axis=0)
    displaced = layer_bins + 4 * gaussian_filter1d(
        rng.standard_normal(layer_bins.shape), 10, axis=1
    )
    fading = np.clip(0.6 + 15 * gaussian_filter(rng.standard_normal(shape), 12), 0, 1)
    lines = 3 * gaussian_filter(layer_mask(displaced, n_rows).astype(float), 1.2)
    noise = 0.45 * gaussian_filter(rng.standard_normal(shape), 1.5)
    return np.clip(lines * fading + noise, 0, 1), layer_mask(layer_bins, n_rows)


def sparse_assignment(predicted, truth):
    """Number of pairs by SciPy's minimum-cost assignment, connected component by component."""
    a, b = np.argwhere(predicted), np.argwhere(truth)
    near = cKDTree(a).sparse_distance_matrix(
        cKDTree(b), MAX_DIST * np.hypot(*truth.shape), output_type="coo_matrix"
    )
    both = coo_matrix((near.data + 1, (near.row, near.col + len(a))), shape=(len(a) + len(b),) * 2)
    n_parts, part = connected_components(both, directed=False)
    n_a, row_in_part = number_in_part(part[: len(a)], n_parts)
    n_b, column_in_part = number_in_part(part[len(a) :], n_parts)
    edges = np.argsort(part[near.row], kind="stable")
    ends = np.cumsum(np.bincount(part[near.row], minlength=n_parts))
    # A part with one pixel on either side holds one pair.
    n_pairs = int((np.minimum(n_a, n_b) == 1).sum())
    for which in np.flatnonzero(np.minimum(n_a, n_b) > 1):
        here = edges[ends[which - 1] if which else 0 : ends[which]]
        alone = np.arange(n_a[which])
        # Any number of pixels may stay alone, at a price above every chain of pairs.
        price = np.concatenate([near.data[here] + 1, np.full(alone.size, 1e6)])
        rows = np.concatenate([row_in_part[near.row[here]], alone])
        columns = np.concatenate([column_in_part[near.col[here]], n_b[which] + alone])
        graph = coo_matrix(
            (price, (rows, columns)), shape=(alone.size, alone.size + n_b[which])
        ).tocsr()
        n_pairs += int((min_weight_full_bipartite_matching(graph)[1] < n_b[which]).sum())
    return n_pairs


def number_in_part(part, n_parts):
    """Size of every part, and every member's number within its own."""
    sizes = np.bincount(part, minlength=n_parts)
    number = np.empty(part.size, dtype=int)
    number[np.argsort(part, kind="stable")] = np.arange(part.size) - np.repeat(
        np.cumsum(sizes) - sizes, sizes
    )
    return sizes, number


def cpu_seconds(function, *arguments, repeats=3):
    """Shortest CPU time of a call [s]."""
    seconds = []
    for _ in range(repeats):
        start = time.process_time()
        function(*arguments)
        seconds.append(time.process_time() - start)
    return min(seconds)


def compare_with_reference():
    """Smaller ratio, of two sizes, of the reference's seconds per image to ours."""
    ratios = []
    for shape, reference_s in REFERENCE_SECONDS.items():
        ours_s = []
        for n_layers in (3, 10, 22):
            prediction, truth = draw_map(
                shape, n_layers, rng=random_stream(0, "reference", *shape, n_layers)
            )
            ours_s.append(cpu_seconds(match_counts, prediction, truth, THRESHOLDS))
            log.info("%s, %2d layers, not suppressed: %.1f ms", shape, n_layers, 1e3 * ours_s[-1])
        ratios.append(reference_s / np.mean(ours_s))
        log.info(
            "%s: %.0f x faster than the reference's %.1f s per image",
            shape,
            ratios[-1],
            reference_s,
        )
    return min(ratios)


def compare_with_sparse_assignment():
    """Smallest ratio of seconds, sparse assignment's to ours, from every ninth threshold."""
    ratios = []
    for shape, n_layers in [((128, 256), 10), ((400, 256), 12)]:
        prediction, truth = draw_map(
            shape, n_layers, rng=random_stream(0, "sparse", *shape, n_layers)
        )
        edges = suppress(prediction)
        some = THRESHOLDS[4::9]
        start = time.process_time()
        pairs = [sparse_assignment(edges >= threshold, truth) for threshold in some]
        sparse_s = (time.process_time() - start) * THRESHOLDS.size / some.size
        # Without thinning, which assignment has no part in.
        ours = match_counts(edges, truth, some, thin=False)["matched_truth"].tolist()
        if ours != pairs:
            msg = f"{shape}: expected {pairs} pairs, got {ours}"
            raise ValueError(msg)
        ours_s = cpu_seconds(match_counts, edges, truth, THRESHOLDS)
        ratios.append(sparse_s / ours_s)
        log.info("%s, %2d layers: %.1f ms", shape, n_layers, 1e3 * ours_s)
        log.info("    %.0f x faster than sparse assignment's %.2f s", ratios[-1], sparse_s)
    return min(ratios)


def score_run(run, n_images=60, n_outputs=6):
    """Suppress and count the maps of one tracker; CPU seconds without making them."""
    seconds = 0.0
    for image in range(n_images):
        rng = random_stream(0, "run", run, image)
        shape = (int(rng.integers(300, 520)), 256)
        for _ in range(n_outputs):
            prediction, truth = draw_map(shape, int(rng.integers(4, 34)), rng=rng)
            start = time.process_time()
            match_counts(suppress(prediction), truth, THRESHOLDS)
            seconds += time.process_time() - start
    return seconds


def score_files(n_images=40):
    """CPU seconds an image of 300 x 256 of `score_folders`.

    Reading, suppression, 99 thresholds, picks, bootstrap.
    """
    with tempfile.TemporaryDirectory() as folder:
        maps, masks = Path(folder, "predictions"), Path(folder, "truth")
        for image in range(n_images):
            prediction, truth = draw_map(
                (300, 256), 4 + image % 30, rng=random_stream(0, "files", image)
            )
            write_image(maps / f"data_{image:03d}.png", (255 * prediction).astype(np.uint8))
            write_image(masks / f"layer_binary_{image:03d}.png", truth)
        return cpu_seconds(score_folders, maps, masks) / n_images


def first_calls():
    """Seconds of a process's first image, without and with compiled code at hand."""
    with tempfile.TemporaryDirectory() as folder:
        process = {
            "args": [sys.executable, "-c", FIRST_CALL],
            "env": {**os.environ, "NUMBA_CACHE_DIR": folder},
            "check": True,
            "capture_output": True,
        }
        return [float(subprocess.run(**process).stdout) for _ in range(2)]


def main():
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    match_counts(suppress(np.eye(64)), np.eye(64), THRESHOLDS)  # compile
    reference, sparse = compare_with_reference(), compare_with_sparse_assignment()
    start = time.perf_counter()
    with ProcessPoolExecutor(max_workers=2) as pool:
        seconds = list(pool.map(score_run, range(4)))
    wall_s = time.perf_counter() - start
    log.info(
        "4 runs x 6 outputs x 60 images: %.1f ms per map, %.0f s in all",
        sum(seconds) / 1.44,
        sum(seconds),
    )
    log.info("    %.0f s of CPU on each of two cores", sum(seconds) / 2)
    log.info(
        "    %.0f s on the wall, the making of the maps included and whatever else the machine did",
        wall_s,
    )
    files_s = score_files()
    log.info("files of 300 x 256 pixels: %.1f ms of CPU an image", 1e3 * files_s)
    log.info(
        "first image of a process: %.1f s while compiling, %.2f s with compiled code at hand",
        *first_calls(),
    )
    targets = {
        "100 x faster than the reference": reference >= 100,
        "5 x faster than sparse assignment": sparse >= 5,
        "60 ms for files of an image": files_s < 0.06,
        "4 runs in under 2 minutes on two cores": sum(seconds) / 2 < 120,
    }
    for target, reached in targets.items():
        log.info("%s: %s", target, "reached" if reached else "MISSED")
    return 0 if all(targets.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
