"""PHY beside its equations as printed, one process and one thread: ``make benchmarks``.

Each group of the printed table holds the form as printed and faster ones; the numbers in brackets
are ratios to the fastest of the group. A 256 x 256 scene of 15 layers, 100 looks; scenes include
checks and 8-bit scaling.
"""

import numpy as np
import pytest

from evaluation.lib.literal_phy import convolved_power, render_as_printed, waveforms_of
from snowsim.echogram import to_uint8
from snowsim.phy import draw_speckle, mean_power, render
from snowsim.phy.power import exact_power, table_power

N_BINS = N_LINES = 256
N_LAYERS = 15
SHAPES = ("peak_power", "variance_bins2", "decay_rate")


def planted_scene(n_layers, n_range_lines, n_range_bins, rng):
    """Wavy layers, 0 to -20 dB, over noise of -30 dB."""
    depth = np.linspace(50, n_range_bins - 30, n_layers)[:, None]
    layer_bins = np.sort(
        depth + 0.3 * np.cumsum(0.1 * rng.standard_normal((n_layers, n_range_lines)), axis=1),
        axis=0,
    )
    parameters = {
        "peak_power": np.geomspace(1, 0.01, n_layers),
        "variance_bins2": rng.uniform(10, 15, n_layers),
        "decay_rate": rng.uniform(0.05, 0.09, n_layers),
        "noise_power": 1e-3,
        "n_looks": 100,
    }
    return layer_bins, parameters


@pytest.fixture
def rng():
    return np.random.default_rng(1)


@pytest.fixture
def scene(rng):
    return planted_scene(N_LAYERS, N_LINES, N_BINS, rng)


@pytest.mark.benchmark(group="whole scene, 8-bit scaling included")
@pytest.mark.parametrize(
    "method", ["one float32 normal per pixel", "as printed", "exact", "tables"]
)
def test_scene(benchmark, scene, rng, method):
    layer_bins, parameters = scene
    if method == "one float32 normal per pixel":
        benchmark(rng.standard_normal, (N_BINS, N_LINES), dtype=np.float32)
        return

    def make():
        if method == "as printed":
            return to_uint8(render_as_printed(layer_bins, parameters, N_BINS, rng=rng))
        exact = method == "exact"
        return to_uint8(render(layer_bins, parameters, N_BINS, rng=rng, exact=exact))

    image, _, _ = benchmark(make)
    assert image.shape == (N_BINS, N_LINES)


@pytest.mark.benchmark(
    group="as the workflow calls it, radiometry measured, 8-bit scaling included"
)
@pytest.mark.parametrize("n_looks", [16, 100])
@pytest.mark.parametrize("correlation", ["one float32 normal per pixel", "none", "measured"])
def test_workflow(benchmark, rng, n_looks, correlation):
    if correlation.startswith("one"):
        benchmark(rng.standard_normal, (N_BINS, N_LINES), dtype=np.float32)
        return
    layer_bins, parameters = planted_scene(N_LAYERS, N_LINES, N_BINS, rng)
    # Unpicked snow: a layer for each of three e-folding depths, within a bin below the surface.
    layer_bins = np.insert(layer_bins, 1, layer_bins[0] + [[0.25], [0.5], [0.75]], axis=0)
    parameters = {
        name: np.insert(parameters[name], 1, [0.01] * 3) if name in SHAPES else of
        for name, of in parameters.items()
    }
    parameters["variance_bins2"][1:4] = 10
    fading = 10 ** (0.1 * rng.standard_normal(layer_bins.shape))
    varied = {
        "peak_power": parameters["peak_power"][:, None] * fading,
        "n_looks": n_looks,
        "line_gain_spread_db": 0.4,
    }
    varied["decay_rate"] = np.insert(rng.uniform(0.03, 0.15, N_LAYERS), 1, [0.05, 0.03, 0.01])
    if correlation == "measured":
        varied["speckle_correlation"] = [1.0, 0.54, 0.06]

    def make():
        return to_uint8(render(layer_bins, parameters | varied, N_BINS, rng=rng))

    image, _, _ = benchmark(make)
    assert image.shape == (N_BINS, N_LINES)


@pytest.mark.benchmark(group="mean power")
@pytest.mark.parametrize("way", [convolved_power, exact_power, table_power])
def test_mean_power(benchmark, scene, way):
    layer_bins, parameters = scene
    shapes = [parameters[name] for name in SHAPES]
    waveforms = waveforms_of(layer_bins, parameters, N_BINS)
    power = benchmark(way, waveforms)
    exact = mean_power(layer_bins, *shapes, N_BINS, exact=True)
    error_db = 10 * np.log10(
        (power + parameters["noise_power"]) / (exact + parameters["noise_power"])
    )
    benchmark.extra_info["largest_error_db"] = float(np.abs(error_db).max())


@pytest.mark.benchmark(group="speckle")
@pytest.mark.parametrize("method", ["looks", "gamma", "quantile"])
def test_speckle(benchmark, scene, rng, method):
    layer_bins, parameters = scene
    mean = (
        mean_power(layer_bins, *(parameters[name] for name in SHAPES), N_BINS)
        + parameters["noise_power"]
    )
    benchmark(draw_speckle, mean.astype(np.float32), 100, method=method, rng=rng)
