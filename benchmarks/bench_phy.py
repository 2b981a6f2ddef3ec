"""PHY beside the literal form, in one process and one thread: ``OMP_NUM_THREADS=1 python benchmarks/bench_phy.py``.

Writes nanoseconds per pixel and ratios, medians of repeats. Times include checks, plan and 8-bit scaling.
"""

import sys
import time

import numpy as np

from snowsim.echogram import to_uint8
from snowsim.phy import draw_speckle, mean_power, plan, render
from snowsim.phy.literal import mean_power_by, render_literal

TOLERANCE_DB = 0.05


def planted_scene(n_layers, n_range_lines, n_range_bins, rng):
    """Wavy layers, 0 to -20 dB, over noise of -30 dB."""
    depth = np.linspace(50, n_range_bins - 30, n_layers)[:, None]
    layer_bins = np.sort(depth + 0.3 * np.cumsum(0.1 * rng.standard_normal((n_layers, n_range_lines)), axis=1), axis=0)
    parameters = {
        "peak_power": np.geomspace(1, 0.01, n_layers),
        "variance_bins2": rng.uniform(10, 15, n_layers),
        "decay_rate": rng.uniform(0.05, 0.09, n_layers),
        "noise_power": 1e-3,
        "n_looks": 100,
    }
    return layer_bins, parameters


def nanoseconds(work, n_pixels, repeats):
    """Median time of one call per pixel, after one call that is not counted."""
    work()
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - start)
    return np.median(seconds) / n_pixels * 1e9


def say(text):
    sys.stdout.write(text + "\n")


def compare(n_layers=15, n_range_lines=256, n_range_bins=256):
    rng = np.random.default_rng(1)
    layer_bins, parameters = planted_scene(n_layers, n_range_lines, n_range_bins, rng)
    shape = (n_range_bins, n_range_lines)
    n_pixels = n_range_bins * n_range_lines
    normal = nanoseconds(lambda: rng.standard_normal(shape, dtype=np.float32), n_pixels, 200)
    say(f"{n_layers} layers, {n_range_bins} x {n_range_lines} pixels; one float32 normal: {normal:.2f} ns per pixel")

    literal = nanoseconds(lambda: to_uint8(render_literal(layer_bins, parameters, n_range_bins, rng=rng)), n_pixels, 3)
    say(f"scene, literal: {literal:.0f} ns per pixel")
    for speckle in ("quantile", "cube", "gamma"):

        def scene(speckle=speckle):
            power = render(layer_bins, parameters, n_range_bins, tolerance_db=TOLERANCE_DB, rng=rng, speckle=speckle)
            return to_uint8(power)

        fast = nanoseconds(scene, n_pixels, 200)
        predicted = plan(layer_bins, parameters, n_range_bins, tolerance_db=TOLERANCE_DB, speckle=speckle).cost_normals
        say(
            f"scene, {TOLERANCE_DB} dB, {speckle}: {fast:.1f} ns per pixel, {fast / normal:.2f} normals "
            f"(plan without 8 bits: {predicted:.2f}), {literal / fast:.0f} times faster than literal"
        )

    shapes = [parameters[name] for name in ("peak_power", "variance_bins2", "decay_rate")]
    options = {"tolerance_db": TOLERANCE_DB, "noise_power": parameters["noise_power"]}
    exact = mean_power(layer_bins, *shapes, n_range_bins) + parameters["noise_power"]
    for way in ("convolved", "closed_form", "closed_form_in_support", "recursive", "table"):

        def power(way=way):
            return mean_power_by(way, layer_bins, *shapes, n_range_bins, **options)

        cost = nanoseconds(power, n_pixels, 200 if way == "table" else 5)
        error_db = np.abs(10 * np.log10((power() + parameters["noise_power"]) / exact)).max()
        say(f"mean power, {way}: {cost:.1f} ns per pixel, error {error_db:.1e} dB")

    for method in ("looks", "gamma", "cube", "quantile"):
        mean = exact.astype(np.float32)
        repeats = 3 if method == "looks" else 200
        cost = nanoseconds(lambda m=method, p=mean: draw_speckle(p, 100, method=m, rng=rng), n_pixels, repeats)
        say(f"speckle, {method}: {cost:.1f} ns per pixel")


if __name__ == "__main__":
    compare()
    compare(n_layers=30, n_range_bins=1024)
