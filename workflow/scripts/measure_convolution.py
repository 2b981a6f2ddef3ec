"""How good the convolution model is: errors of simpler models against a coherent one, of waveforms, and their cost.

Three questions, one table:

- stacks: what single scattering and the incoherent sum of eq. (1) leave out, against a transfer matrix with all
  multiples, by density contrast, number of layers, ice lenses and strength of the fine layering;
- tail: what eq. (1), a Gaussian convolved with one exponential, leaves of the off-nadir tail that the nature run
  integrates over annuli, by how far down the tail is followed and by what shapes it;
- scene: seconds of one 256 x 256 scene by each model.

Errors are in decibels over thermal noise as far below the surface as the reference flight has it. The stacks end in air
above; looks differ in where each interface lies, by more than a wavelength there and back.
"""

from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
from job import job

from lib.diagnostics.coherent import draw_lenses, draw_years, interface_delays_s, layered
from lib.diagnostics.convolution import MODELS, bias_db, error_db, model_works, sweep_frequencies_hz
from lib.diagnostics.phy_alternatives import render_literal
from lib.diagnostics.phy_errors import fit_waveform, planted_scene
from lib.timing import device_name, time_rounds
from snowsim.constants import START_FREQUENCY_HZ
from snowsim.io.files import write_table
from snowsim.phy import render
from snowsim.reference import checked_settings, draw_climate, draw_scene
from snowsim.reference.echo import draw_layering
from snowsim.reference.firn import (
    refractive_index_kovacs95,
    surface_reflectivity,
    travel_time_s,
)
from snowsim.reference.radar import interface_waveform, range_response
from snowsim.seeding import random_stream

CONTRASTS_KG_M3 = (3, 10, 30, 50, 100, 170, 240, 300, 450, 600)
N_LAYERS = (1, 2, 5, 10, 20, 50, 100)
N_LENSES = (0, 1, 2, 4, 8, 16)
LAYERING_KG_M3 = (10, 25, 50, 100)
DEFAULT_SLABS, DEFAULT_SLAB_M, MEAN_DENSITY_KG_M3 = 20, 0.25, 450.0
LENS_STACK_KG_M3, LENS_M = 100.0, 0.03
DEPTH_M = 5.0
LOOKS = 32
LONGEST_S = 120e-9  # multiples of twice the depth are still told from first echoes
N_BINS = 220
TAILS_DB = (10, 15, 20, 25, 30)
SHAPING_DB = 20
SHAPED_BY = {
    "diffuse share": ("diffuse_share", (0.0, 0.0003, 0.0007, 0.002, 0.005)),
    "beam width": ("beamwidth_deg", (5.0, 10.0, 20.0, 40.0, 80.0)),
    "height": ("height_m", (250.0, 500.0, 1500.0, 4000.0)),
    "roughness": ("roughness_m", (0.005, 0.02, 0.05, 0.1)),
}
UNITS = {"diffuse share": "1", "beam width": "degrees", "height": "m", "roughness": "m"}
SCENE_LINES = SCENE_BINS = 256
SCENE_LAYERS, SCENE_TOLERANCE_DB = 15, 0.05


def row(part, sweep, value, unit, method, reference, **numbers):
    return {
        "part": part,
        "sweep": sweep,
        "value": value,
        "unit": unit,
        "method": method,
        "reference": reference,
        "error_db": np.nan,
        "layer_error_db": np.nan,
        "bias_db": np.nan,
        "seconds": np.nan,
        "device": device_name(),
    } | numbers


def stack_rows(sweep, value, unit, density, thickness_m, radar):
    """Errors of all models on one ensemble of stacks under air, and seconds of one look and range line."""
    index = refractive_index_kovacs95(density)
    index = np.concatenate([np.ones((len(index), 1)), index], axis=1)
    delay_s = (np.arange(N_BINS) - 10) * radar.bin_size_s
    stop_hz = START_FREQUENCY_HZ + radar.bandwidth_hz
    frequency_hz = sweep_frequencies_hz(START_FREQUENCY_HZ, stop_hz, LONGEST_S)
    works = model_works(index, thickness_m, frequency_hz, delay_s, radar.bandwidth_hz)
    powers = {}
    timed = {name: lambda name=name, work=work: powers.update({name: work()}) for name, work in works.items()}
    runs = time_rounds(timed, 1, n_warm_up=0)
    seconds = {name: seconds / len(index) for name, _, seconds in runs}
    reference = powers["transfer matrix"]
    layers_s = interface_delays_s(index, thickness_m).mean(axis=0)
    inside = (delay_s >= 0) & (delay_s <= layers_s[-1])
    at_layers = np.unique(np.rint(layers_s[1:] / radar.bin_size_s).astype(int) + 10)
    at_layers = at_layers[at_layers < N_BINS]
    noise_power = surface_reflectivity(density[0, 0]) * 10 ** (-radar.surface_to_noise_db / 10)
    return [
        row(
            "stacks",
            sweep,
            value,
            unit,
            name,
            "transfer matrix",
            error_db=error_db(powers[name][inside], reference[inside], noise_power),
            layer_error_db=error_db(powers[name][at_layers], reference[at_layers]),
            bias_db=bias_db(powers[name][inside], reference[inside]),
            seconds=seconds[name],
        )
        for name in MODELS
    ]


def measure_stacks(settings, seed):
    radar, firn = settings.radar, settings.firn
    looks = {"mean_density_kg_m3": MEAN_DENSITY_KG_M3, "roughness_m": radar.roughness_m}
    rows = []
    for contrast in CONTRASTS_KG_M3:
        rng = random_stream(seed, "measure_convolution", "contrast", contrast)
        stack = draw_years(LOOKS, DEFAULT_SLABS, float(contrast), slab_m=DEFAULT_SLAB_M, **looks, rng=rng)
        rows += stack_rows("density contrast", contrast, "kg m-3", *stack, radar)
    for n_layers in N_LAYERS:
        rng = random_stream(seed, "measure_convolution", "layers", n_layers)
        slab_m = min(DEFAULT_SLAB_M, DEPTH_M / n_layers)
        stack = draw_years(LOOKS, n_layers, firn.horizon_jump_kg_m3, slab_m=slab_m, **looks, rng=rng)
        rows += stack_rows("layers", n_layers, "1", *stack, radar)
    for n_lenses in N_LENSES:
        rng = random_stream(seed, "measure_convolution", "lenses", n_lenses)
        stack = draw_years(LOOKS, DEFAULT_SLABS, LENS_STACK_KG_M3, slab_m=DEFAULT_SLAB_M, **looks, rng=rng)
        stack = draw_lenses(*stack, n_lenses, lens_m=LENS_M, rng=rng)
        rows += stack_rows("ice lenses", n_lenses, "1", *stack, radar)
    # Cells of the nature run: a quarter of a range bin in snow of the surface's density.
    density = firn.surface_density_kg_m3
    cell_m = radar.bin_size_s / radar.n_sub_bins / travel_time_s(1.0, density / 1000)
    for sd in LAYERING_KG_M3:
        rng = random_stream(seed, "measure_convolution", "layering", sd)
        fluctuation = draw_layering(LOOKS, int(DEPTH_M / cell_m), cell_m, sd, firn.layering_length_m, rng=rng)
        rows += stack_rows("fine layering", sd, "kg m-3", *layered(fluctuation, density, cell_m), radar)
    return rows


def received(radar, rms_slope):
    """Mean echo of one interface as the nature run receives it, by position [bins]."""
    wave = interface_waveform(radar, rms_slope, radar.roughness_m)
    power = np.convolve(wave.power.astype(float), range_response(radar).astype(float) ** 2)
    return np.arange(power.size) / radar.n_sub_bins, power


def tail_row(sweep, value, unit, radar, rms_slope, tail_db):
    fit = fit_waveform(*received(radar, rms_slope), tail_db)
    return row("tail", sweep, value, unit, "PHY", "annuli integral", error_db=fit.rms_db, layer_error_db=fit.largest_db)


def measure_tails(radar):
    rows = [
        tail_row(name, tail_db, "dB below the peak", radar, slope, tail_db)
        for name, slope in (("horizon", radar.horizon_slope), ("surface", radar.surface_slope))
        for tail_db in TAILS_DB
    ]
    for sweep, (name, values) in SHAPED_BY.items():
        for value in values:
            shaped = replace(radar, **{name: value})
            rows.append(tail_row(sweep, value, UNITS[sweep], shaped, radar.horizon_slope, SHAPING_DB))
    return rows


def measure_scenes(settings, n_looks, seed, rows):
    """Seconds of a scene of 256 x 256 pixels and 15 layers by each model, with the error that belongs to it."""
    rng = random_stream(seed, "measure_convolution", "scenes")
    layer_bins, parameters = planted_scene(SCENE_LAYERS, SCENE_LINES, SCENE_BINS, n_looks=n_looks)
    climate = draw_climate(settings, rng=random_stream(seed, "climate"))
    works = {
        "PHY": partial(render, layer_bins, parameters, SCENE_BINS, tolerance_db=SCENE_TOLERANCE_DB, rng=rng),
        "PHY, literal": partial(render_literal, layer_bins, parameters, SCENE_BINS, rng=rng),
    }
    runs = time_rounds(works, 3)
    scene = partial(draw_scene, 0, "test", climate=climate, settings=settings, n_looks=n_looks)
    n_pixels = scene(rng=rng).image.size
    runs += time_rounds({"nature run": partial(scene, rng=rng)}, 2, n_warm_up=0)
    share = {"nature run": SCENE_LINES * SCENE_BINS / n_pixels}

    def errors(part, sweep, value, method):
        [found] = [r for r in rows if (r["part"], r["sweep"], r["value"], r["method"]) == (part, sweep, value, method)]
        return found

    of_tail = errors("tail", "horizon", SHAPING_DB, "PHY")["error_db"]
    of_phases = errors("stacks", "layers", DEFAULT_SLABS, "convolution")["error_db"]
    known = {"PHY": np.hypot(of_tail, of_phases), "PHY, literal": np.hypot(of_tail, of_phases), "nature run": of_phases}
    timed = [
        row(
            "scene", "whole scene", repeat, "repeat", name, "transfer matrix",
            error_db=known[name], seconds=seconds * share.get(name, 1.0),
        )
        for name, repeat, seconds in runs
    ]  # fmt: skip
    for method in MODELS:
        of_stack = errors("stacks", "layers", DEFAULT_SLABS, method)
        seconds = of_stack["seconds"] * SCENE_LINES * n_looks
        known_db = of_stack["error_db"]
        timed.append(
            row(
                "scene", "one look and line, extrapolated", 0, "repeat", f"{method}, stack", "transfer matrix",
                error_db=known_db, seconds=seconds,
            )
        )  # fmt: skip
    return timed


def measure(path_to_table, reference, n_looks, seed, source):
    settings = checked_settings(reference)
    rows = measure_stacks(settings, seed) + measure_tails(settings.radar)
    rows += measure_scenes(settings, n_looks, seed, rows)
    write_table(path_to_table, pd.DataFrame(rows).assign(data=source))


if __name__ == "__main__":
    with job(snakemake):
        measure(*snakemake.output, **snakemake.params)
