"""Whole scenes, 8-bit scaling included: PHY beside the literal form, scatterers, the cGAN and the nature run."""

from functools import partial

import numpy as np
import torch

from lib.diagnostics.phy_alternatives import (
    convolved_power,
    mean_power_by,
    render_literal,
    render_scatterers,
    waveforms_of,
)
from lib.diagnostics.phy_charts import SHAPES, runs_table
from lib.diagnostics.phy_errors import largest_error_db, planted_scene, scattered_mean_power
from lib.timing import time_rounds
from snowsim.cgan import UNetGenerator
from snowsim.cgan import render as render_cgan
from snowsim.echogram import layer_mask, to_uint8
from snowsim.phy import plan, render
from snowsim.phy.power import mean_power
from snowsim.reference import draw_scene

TOLERANCES_DB = (0.5, 0.1, 0.05, 0.01)
SCATTERER_LINES = 4  # of the scatterers' scene: its cost is the same for every range line
RANGE_LINES = (16, 64, 256, 1024, 4096)
LAYERS = (1, 2, 5, 10, 20, 40, 80)
GROWTH_TOLERANCE_DB = 0.05


def eight_bits(draw, *given, **options):
    """Render and scale, as every scene that is written."""
    return to_uint8(draw(*given, **options))


def phy_works(layer_bins, parameters, n_range_bins, rng):
    """Renderers of eq. (1): work and largest error of the mean [dB] by (setting, method)."""
    shapes = {name: parameters[name] for name in SHAPES} | {"n_range_bins": n_range_bins}
    noise_power = parameters["noise_power"]
    given = (layer_bins, parameters, n_range_bins)
    waveforms = waveforms_of(layer_bins, parameters, n_range_bins, "peak", "peak")
    exact = mean_power(layer_bins, **shapes)
    literal = (f"M = {parameters['n_looks']}", "literal")
    works = {literal: partial(eight_bits, render_literal, *given, rng=rng)}
    means = {literal: convolved_power(waveforms)}
    works["exact", "PHY exact"] = partial(eight_bits, render, *given, tolerance_db=None, rng=rng)
    means["exact", "PHY exact"] = exact
    for tolerance_db in TOLERANCES_DB:
        key = (f"{tolerance_db:g} dB", "PHY")
        works[key] = partial(eight_bits, render, *given, tolerance_db=tolerance_db, rng=rng)
        means[key] = mean_power_by("table", waveforms, tolerance_db=tolerance_db, noise_power=noise_power)
    return works, {key: largest_error_db(mean, exact, noise_power) for key, mean in means.items()}


def scatterer_work(layer_bins, parameters, n_range_bins, rng):
    """The sum over 100 scatterers per layer and range line, and the largest error of its mean [dB]."""
    given = (layer_bins, parameters, n_range_bins)
    exact = mean_power(layer_bins, **{name: parameters[name] for name in SHAPES}, n_range_bins=n_range_bins)
    scattered = scattered_mean_power(*given, align="peak") - parameters["noise_power"]
    work = partial(eight_bits, render_scatterers, *given, rng=rng, align="peak")
    return work, largest_error_db(scattered, exact, parameters["noise_power"])


def cgan_work(layer_bins, n_range_bins, settings, rng):
    """A generator of the configured size; what it has learned makes no difference to its cost."""
    torch.set_num_threads(1)
    generator = UNetGenerator(settings["width"], settings["depth"]).to(memory_format=torch.channels_last).eval()
    mask = layer_mask(layer_bins, n_range_bins)
    return partial(render_cgan, generator, mask, statistics="scene", precision=settings["precision"], rng=rng)


def time_scenes(n_layers, n_range_lines, n_range_bins, n_rounds, *, reference, climate, cgan, n_looks, stream):
    """Seconds of whole scenes by each model, and largest error of the mean [dB] where it is a model of eq. (1).

    `reference` and `climate` are the reference flight's; `stream` gives the random generator of some keys.
    """
    rng = stream()
    layer_bins, parameters = planted_scene(n_layers, n_range_lines, n_range_bins)
    works, errors_db = phy_works(layer_bins, parameters, n_range_bins, rng)
    few = ("100 scatterers", "scatterers")
    works[few], errors_db[few] = scatterer_work(layer_bins[:, :SCATTERER_LINES], parameters, n_range_bins, rng)
    works[f"width {cgan['width']}", "cGAN"] = cgan_work(layer_bins, n_range_bins, cgan, rng)
    works["floor", "float32 normal"] = partial(rng.standard_normal, (n_range_bins, n_range_lines), dtype=np.float32)
    runs = time_rounds(works, n_rounds)

    draw = partial(draw_scene, 0, "test", climate=climate, settings=reference, n_looks=n_looks)
    nature = (f"{n_looks} looks", "nature run")
    scene = draw(rng=stream("reference"))
    # Drawn once already: no warm-up. Its scenes take much longer than the others.
    runs += time_rounds({nature: partial(draw, rng=stream("timed"))}, 2, n_warm_up=0)
    about = {key: {"error_db": error_db} for key, error_db in errors_db.items()}
    about[few]["n_pixels"] = n_range_bins * SCATTERER_LINES
    about[nature] = {"n_pixels": scene.image.size}
    columns = ["setting", "method", "repeat", "seconds", "n_pixels", "error_db", "device"]
    return runs_table(runs, about, columns, n_pixels=n_range_bins * n_range_lines)


def time_growth(n_layers, n_range_lines, n_range_bins, n_rounds, *, rng):
    """Seconds of a scene against its range lines and against its layers, and what its plan predicts [ms]."""
    sizes = [("pixels", n_layers, lines, n_range_bins) for lines in RANGE_LINES]
    sizes += [("layers", layers, n_range_lines, 4 * n_range_bins) for layers in LAYERS]
    works, about = {}, {}
    normals = partial(rng.standard_normal, (n_range_bins, n_range_lines), dtype=np.float32)
    seconds = [seconds for _, _, seconds in time_rounds({"normal": normals}, n_rounds)]
    normal_s = min(seconds) / (n_range_bins * n_range_lines)
    for setting, layers, lines, height in sizes:
        layer_bins, parameters = planted_scene(layers, lines, height)
        given = (layer_bins, parameters, height)
        size = {"n_layers": layers, "n_pixels": lines * height}
        key = (setting, layers, lines, "PHY")
        works[key] = partial(eight_bits, render, *given, tolerance_db=GROWTH_TOLERANCE_DB, rng=rng)
        cost = plan(*given, tolerance_db=GROWTH_TOLERANCE_DB).cost_normals
        about[key] = size | {"plan_ms": cost * normal_s * lines * height * 1e3}
        if setting == "pixels" and lines <= n_range_lines:
            key = (setting, layers, lines, "PHY exact")
            works[key] = partial(eight_bits, render, *given, tolerance_db=None, rng=rng)
            about[key] = size | {"plan_ms": np.nan}
    columns = ["setting", "n_layers", "n_pixels", "method", "plan_ms", "repeat", "seconds", "device"]
    return runs_table(time_rounds(works, 3 * n_rounds), about, columns)
