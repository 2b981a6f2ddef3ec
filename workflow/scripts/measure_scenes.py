"""Whole scenes, 8-bit scaling included: PHY beside the literal form, scatterers, the cGAN and the nature run."""

from functools import partial

import numpy as np
import pandas as pd
import torch
from job import job

from lib.diagnostics.phy_alternatives import convolved_power, mean_power_by, render_literal, render_scatterers
from lib.diagnostics.phy_errors import largest_error_db, planted_scene, scattered_mean_power
from lib.timing import device_name, time_rounds
from snowsim.cgan import UNetGenerator
from snowsim.cgan import render as render_cgan
from snowsim.echogram import layer_mask, to_uint8
from snowsim.io.files import write_table
from snowsim.phy import plan, render
from snowsim.phy.parameters import checked_waveforms
from snowsim.phy.power import mean_power
from snowsim.reference import checked_settings, draw_climate, draw_scene
from snowsim.seeding import random_stream

TOLERANCES_DB = (0.5, 0.1, 0.05, 0.01)
SCATTERER_LINES = 4  # of the scatterers' scene: its cost is the same for every range line
RANGE_LINES = (16, 64, 256, 1024, 4096)
LAYERS = (1, 2, 5, 10, 20, 40, 80)
GROWTH_TOLERANCE_DB = 0.05
SHAPES = ("peak_power", "variance_bins2", "decay_rate")


def eight_bits(draw, *given, **options):
    """Render and scale, as every scene that is written."""
    return to_uint8(draw(*given, **options))


def phy_works(layer_bins, parameters, n_range_bins, rng):
    """Renderers of eq. (1): work and largest error of the mean [dB] by (setting, method)."""
    shapes = {name: parameters[name] for name in SHAPES}
    noise_power = parameters["noise_power"]
    given = (layer_bins, parameters, n_range_bins)
    exact = mean_power(layer_bins, **shapes, n_range_bins=n_range_bins)
    waveforms = checked_waveforms(layer_bins, **shapes, n_range_bins=n_range_bins, normalise="peak", align="peak")
    of_looks = f"M = {parameters['n_looks']}"
    works = {(of_looks, "literal"): partial(eight_bits, render_literal, *given, rng=rng)}
    means = {(of_looks, "literal"): convolved_power(waveforms)}
    works["exact", "PHY exact"] = partial(eight_bits, render, *given, tolerance_db=None, rng=rng)
    means["exact", "PHY exact"] = exact
    for tolerance_db in TOLERANCES_DB:
        key = (f"{tolerance_db:g} dB", "PHY")
        works[key] = partial(eight_bits, render, *given, tolerance_db=tolerance_db, rng=rng)
        means[key] = mean_power_by("table", waveforms, tolerance_db=tolerance_db, noise_power=noise_power)
    return works, {key: largest_error_db(mean, exact, noise_power) for key, mean in means.items()}


def cgan_work(layer_bins, n_range_bins, settings, rng):
    """A generator of the configured size; what it has learned makes no difference to its cost."""
    torch.set_num_threads(1)
    generator = UNetGenerator(settings["width"], settings["depth"]).to(memory_format=torch.channels_last).eval()
    mask = layer_mask(layer_bins, n_range_bins)
    return partial(render_cgan, generator, mask, statistics="scene", precision=settings["precision"], rng=rng)


def measure_scenes(path_to_table, n_layers, n_range_lines, n_range_bins, n_rounds, seed, reference, cgan, n_looks):
    rng = random_stream(seed, "measure_scenes")
    layer_bins, parameters = planted_scene(n_layers, n_range_lines, n_range_bins)
    works, error_db = phy_works(layer_bins, parameters, n_range_bins, rng)
    n_pixels = dict.fromkeys(works, n_range_bins * n_range_lines)

    few = layer_bins[:, :SCATTERER_LINES]
    key = ("100 scatterers", "scatterers")
    works[key] = partial(eight_bits, render_scatterers, few, parameters, n_range_bins, rng=rng, align="peak")
    scattered = scattered_mean_power(few, parameters, n_range_bins, align="peak")
    exact = mean_power(few, **{name: parameters[name] for name in SHAPES}, n_range_bins=n_range_bins)
    error_db[key] = largest_error_db(scattered - parameters["noise_power"], exact, parameters["noise_power"])
    n_pixels[key] = n_range_bins * SCATTERER_LINES

    works[f"width {cgan['width']}", "cGAN"] = cgan_work(layer_bins, n_range_bins, cgan, rng)
    works["floor", "float32 normal"] = partial(rng.standard_normal, (n_range_bins, n_range_lines), dtype=np.float32)
    runs = time_rounds(works, n_rounds)

    settings = checked_settings(reference)
    climate = draw_climate(settings, rng=random_stream(seed, "climate"))
    draw = partial(draw_scene, 0, "test", climate=climate, settings=settings, n_looks=n_looks)
    key = (f"{n_looks} looks", "nature run")
    scene = draw(rng=random_stream(seed, "measure_scenes", "reference"))
    n_pixels[key] = scene.image.size
    # Drawn once already: no warm-up. Its scenes take much longer than the others.
    runs += time_rounds({key: partial(draw, rng=random_stream(seed, "measure_scenes", "timed"))}, 2, n_warm_up=0)
    rows = [
        {
            "setting": key[0],
            "method": key[1],
            "repeat": repeat,
            "seconds": seconds,
            "n_pixels": n_pixels.get(key, n_range_bins * n_range_lines),
            "error_db": error_db.get(key, np.nan),
            "device": device_name(),
        }
        for key, repeat, seconds in runs
    ]
    write_table(path_to_table, pd.DataFrame(rows))


def measure_growth(path_to_table, n_layers, n_range_lines, n_range_bins, n_rounds, seed):
    """Cost of a scene against its range lines and against its layers, and what its plan predicts."""
    rng = random_stream(seed, "measure_growth")
    sizes = [("pixels", n_layers, lines, n_range_bins) for lines in RANGE_LINES]
    sizes += [("layers", layers, n_range_lines, 4 * n_range_bins) for layers in LAYERS]
    works, about = {}, {}
    normals = partial(rng.standard_normal, (n_range_bins, n_range_lines), dtype=np.float32)
    seconds = [seconds for _, _, seconds in time_rounds({"normal": normals}, n_rounds)]
    normal_s = min(seconds) / (n_range_bins * n_range_lines)
    for setting, layers, lines, height in sizes:
        layer_bins, parameters = planted_scene(layers, lines, height)
        given = (layer_bins, parameters, height)
        scene_plan = plan(*given, tolerance_db=GROWTH_TOLERANCE_DB)
        size = {"setting": setting, "n_layers": layers, "n_pixels": lines * height}
        key = (setting, layers, lines, "PHY")
        works[key] = partial(eight_bits, render, *given, tolerance_db=GROWTH_TOLERANCE_DB, rng=rng)
        plan_ms = scene_plan.cost_normals * normal_s * lines * height * 1e3
        about[key] = size | {"method": "PHY", "plan_ms": plan_ms}
        if setting == "pixels" and lines <= n_range_lines:
            key = (setting, layers, lines, "PHY exact")
            works[key] = partial(eight_bits, render, *given, tolerance_db=None, rng=rng)
            about[key] = size | {"method": "PHY exact", "plan_ms": np.nan}
    rows = [
        {**about[key], "repeat": repeat, "seconds": seconds, "device": device_name()}
        for key, repeat, seconds in time_rounds(works, 3 * n_rounds)
    ]
    write_table(path_to_table, pd.DataFrame(rows))


if __name__ == "__main__":
    with job(snakemake):
        params = dict(snakemake.params)
        growth = {key: params[key] for key in ("n_layers", "n_range_lines", "n_range_bins", "n_rounds", "seed")}
        measure_scenes(snakemake.output.scenes, **params)
        measure_growth(snakemake.output.growth, **growth)
