"""Flight statistics and label sets, one process and one thread: ``make benchmarks``.

A planted flight of 20 layers, 700 rows, 2048 range lines: sums over it, then both estimators from
frames to statistics, with range lines a second in the last column of the saved results; then 1500
label sets drawn from it. Seconds of the processor, so that other work on the machine does not
count. The last test prints how memory grows.
"""

import time
import tracemalloc

import numpy as np
import pytest

from evaluation.lib.statistics_atlas import Planted
from snowsim.labels import draw_scene, prepare
from snowsim.statistics import ESTIMATORS, estimate, merge, summarise

N_FRAMES, N_LINES = 2, 1024
N_LABELS = 1500


def planted_flight(n_frames=N_FRAMES):
    """Twenty layers 30 bins apart, 0 to -20 dB."""
    return Planted(
        peak_power=tuple(np.geomspace(1, 0.01, 20)),
        decay_rate=tuple(np.linspace(0.12, 0.07, 20)),
        slab_bins=30.0,
        n_frames=n_frames,
        n_lines=N_LINES,
    )


@pytest.fixture(scope="module")
def frames():
    return list(planted_flight().frames(np.random.default_rng(0)))


@pytest.fixture(scope="module")
def summary(frames):
    return merge(summarise(*frame) for frame in frames)


def report_lines(benchmark, n_lines):
    benchmark.extra_info["range_lines_per_second"] = round(n_lines / benchmark.stats.stats.min)


@pytest.mark.benchmark(group="2048 range lines to sums", timer=time.process_time)
def test_sums(benchmark, frames):
    benchmark.pedantic(
        lambda: merge(summarise(*frame) for frame in frames), rounds=5, warmup_rounds=1
    )
    report_lines(benchmark, N_FRAMES * N_LINES)


@pytest.mark.benchmark(group="2048 range lines to statistics", timer=time.process_time)
@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_fit(benchmark, frames, estimator):
    def fit():
        return estimate(merge(summarise(*frame) for frame in frames), estimator=estimator)

    benchmark.pedantic(fit, rounds=2, warmup_rounds=1)
    report_lines(benchmark, N_FRAMES * N_LINES)


@pytest.mark.benchmark(group="1500 label sets", timer=time.process_time)
@pytest.mark.parametrize("correlation", ["measured", "none"])
def test_labels(benchmark, summary, correlation):
    statistics = estimate(summary)

    def draw():
        model = prepare(statistics, 256, correlation=correlation, radiometry="constant")
        rng = np.random.default_rng(1)
        return [draw_scene(model, 256, name=f"{i}", rng=rng).n_range_bins for i in range(N_LABELS)]

    benchmark.pedantic(draw, rounds=2)


def test_memory_of_the_fit(capsys):
    peaks = {}
    for n_frames in (1, 3):
        tracemalloc.start()
        kept = merge(
            summarise(*frame) for frame in planted_flight(n_frames).frames(np.random.default_rng(0))
        )
        estimate(kept)
        peaks[n_frames] = tracemalloc.get_traced_memory()[1] / 2**20
        tracemalloc.stop()
    per_line = (peaks[3] - peaks[1]) * 2**20 / (2 * N_LINES)
    with capsys.disabled():
        text = ", ".join(f"{n * N_LINES} lines {peak:.0f} MiB" for n, peak in peaks.items())
        line = f"{text}; {per_line:.0f} bytes a further line"
        print(f"\npeak of NumPy's memory in sums and fit: {line}")  # noqa: T201
    assert per_line * 200_000 < 1.5 * 2**30
