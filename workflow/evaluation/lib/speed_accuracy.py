"""Speed against accuracy of PHY: seconds and error of every way to a part, and to a whole scene."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd
import torch
from scipy.special import gammainc

from evaluation.lib.literal_phy import (
    convolved_power,
    largest_error_db,
    planted_scene,
    render_as_printed,
    waveforms_of,
)
from evaluation.lib.machine import device_name, time_rounds
from snowsim.cgan import Settings, networks_of
from snowsim.cgan import render as render_cgan
from snowsim.echogram import Scene, to_uint8
from snowsim.phy import draw_speckle, render
from snowsim.phy.power import (
    NODES_PER_BIN,
    TABLE_RANGE,
    checked_waveforms,
    echoes_of_parameters,
    exact_power,
    power_of,
    table_power,
)
from snowsim.phy.speckle import QUANTILE_REACH, normal_cells, normal_quantiles

N_LAYERS = 15
N_RANGE_BINS = 256
N_RANGE_LINES = 256
NODES = (1, 2, 4, 8, 16, 32, 64)  # of tables, in a bin
# Relative to the scene's peak.
NOISES_DB = (-80, -60, -40, -20)
N_LOOKS = (16, 100)


@dataclass(frozen=True)
class Way:
    """One way to a result: what computes it, and how far it is from exact, where it should be.

    `error_db` is the largest of mean power and noise, `distance` that of the distribution function
    of speckle from Gamma(M).
    """

    method: str
    setting: str
    work: Callable
    error_db: float = np.nan
    distance: float = np.nan


def measured(*, cgan, n_rounds, rng):
    """Every run of every way, a row each; `cgan` are settings of its networks."""
    scene = planted_scene(N_LAYERS, N_RANGE_LINES, N_RANGE_BINS)
    panels = {
        "mean power": waveform_ways(*scene),
        "speckle": speckle_ways(rng),
        "whole scenes": scene_ways(*scene, cgan, rng),
    }
    normals = partial(rng.standard_normal, (N_RANGE_BINS, N_RANGE_LINES), dtype=np.float32)
    floor = Way("one float32 normal a pixel", "floor", normals)
    rows = []
    for panel, ways in panels.items():
        works = {way: way.work for way in [*ways, floor]}
        for way, repeat, seconds in time_rounds(works, n_rounds):
            row = {"panel": panel, **vars(way), "repeat": repeat, "seconds": seconds}
            rows.append(row)
    table = pd.DataFrame(rows).drop(columns="work")
    return table.assign(n_pixels=N_RANGE_BINS * N_RANGE_LINES, device=device_name())


def waveform_ways(layer_bins, parameters):
    """Mean power: columns convolved, the closed form on every pixel, sub-bin tables.

    Errors of tables are the largest of all scenes that they are meant for, others this scene's.
    """
    waveforms = waveforms_of(layer_bins, parameters, N_RANGE_BINS)
    noise_power = parameters["noise_power"]
    exact = exact_power(waveforms)

    def way(method, setting, work):
        return Way(method, setting, work, largest_error_db(work(), exact, noise_power))

    ways = [way("closed form", "every pixel", partial(exact_power, waveforms))]
    for n_samples in (1, 4):
        work = partial(convolved_power, waveforms, samples_per_bin=n_samples)
        ways.append(way("convolution", f"{n_samples} a bin", work))
    for nodes in NODES:
        work = partial(table_power, waveforms, nodes)
        ways.append(Way("table", f"{nodes} a bin", work, table_error_db(nodes)))
    return ways


def table_error_db(nodes_per_bin):
    """Largest error [dB] of a layer's table: all shapes and noises that tables are meant for.

    Of shapes an even grid of logarithms, the limits included; on 16 range lines of an odd number of
    sub-bin positions.
    """
    variances, decays = (np.geomspace(*limits, 7) for limits in TABLE_RANGE.values())
    layer_bins = 100 + np.arange(16)[None] / 17
    errors_db = []
    for variance in variances:
        for decay in decays:
            echoes = echoes_of_parameters(layer_bins, [1.0], [variance], [decay])
            layer = checked_waveforms(echoes, N_RANGE_BINS)
            exact = exact_power(layer)
            tabulated = table_power(layer, nodes_per_bin)
            for noise_db in NOISES_DB:
                errors_db.append(largest_error_db(tabulated, exact, 10 ** (noise_db / 10)))
    return max(errors_db)


def speckle_ways(rng):
    """Speckle: looks summed, Gamma drawn, quantiles looked up."""
    ones = np.ones((N_RANGE_BINS, N_RANGE_LINES), dtype=np.float32)
    ways = []
    for n_looks in N_LOOKS:
        setting = f"M = {n_looks}"
        draw = partial(draw_speckle, ones, n_looks, rng=rng)
        distance = quantile_distance(n_looks)
        ways += [
            Way("looks", setting, partial(draw, method="looks"), distance=0.0),
            Way("gamma", setting, partial(draw, method="gamma"), distance=0.0),
            Way("quantile", setting, partial(draw, method="quantile"), distance=distance),
        ]
    return ways


def quantile_distance(n_looks):
    """Largest distance of the distribution functions of speckle methods `quantile` and `gamma`."""
    table = normal_quantiles(float(n_looks))
    normal = np.linspace(-QUANTILE_REACH, QUANTILE_REACH, table.size)
    drawn = np.interp(normal_cells(), normal, table)
    exact = gammainc(n_looks, n_looks * drawn)
    above_start = exact - np.arange(drawn.size) / drawn.size
    above_end = above_start - 1 / drawn.size
    return float(max(np.abs(above_start).max(), np.abs(above_end).max()))


def scene_ways(layer_bins, parameters, cgan, rng):
    """Whole scenes, 8-bit scaling included: PHY as printed, exact and by tables; the cGAN.

    The cGAN does not model eq. (1) and has no error against it; what it has learned makes no
    difference to its cost.
    """
    given = (layer_bins, parameters, N_RANGE_BINS)
    noise_power = parameters["noise_power"]
    waveforms = waveforms_of(*given)
    exact = exact_power(waveforms)
    literal = largest_error_db(convolved_power(waveforms), exact, noise_power)
    by_default = largest_error_db(power_of(waveforms), exact, noise_power)

    def phy(**how):
        return to_uint8(render(*given, rng=rng, **how))

    settings = Settings(**cgan)
    generator = networks_of(settings)[0].to(memory_format=torch.channels_last).eval()
    echoes = echoes_of_parameters(layer_bins, **parameters)
    masked = Scene("planted", N_RANGE_BINS, layer_bins, echoes=echoes)
    return [
        Way(
            "PHY, as printed",
            f"M = {parameters['n_looks']}",
            lambda: to_uint8(render_as_printed(*given, rng=rng)),
            literal,
        ),
        Way("PHY, exact", "closed form", partial(phy, exact=True), 0.0),
        Way("PHY", f"{NODES_PER_BIN} nodes a bin", phy, by_default),
        Way(
            "cGAN",
            f"width {settings.width}",
            lambda: render_cgan(generator, masked, settings, rng=rng),
        ),
    ]
