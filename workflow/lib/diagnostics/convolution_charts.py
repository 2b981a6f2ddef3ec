"""Accuracy of the convolution model: errors of simpler models against a coherent one, of waveforms, and their cost.

Errors are in decibels over thermal noise as far below the surface as the reference flight has it.
Stacks end in air above; looks differ in where each interface lies, by more than a wavelength there
and back.
"""

from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np
import pandas as pd

from lib.diagnostics import coherent
from lib.diagnostics.phy_alternatives import render_as_printed
from lib.diagnostics.phy_errors import fit_waveform, planted_scene
from lib.diagnostics.simulation import simulation_rows
from lib.machine import device_name, time_rounds
from snowsim.constants import START_FREQUENCY_HZ
from snowsim.phy import render
from snowsim.reference import draw_scene
from snowsim.reference.echo import draw_layering
from snowsim.reference.firn import refractive_index_kovacs95, surface_reflectivity, travel_time_s
from snowsim.reference.radar import interface_waveform, range_response

COLUMNS = [
    *("part", "sweep", "value", "unit", "method", "reference"),
    *("error_db", "layer_error_db", "bias_db", "seconds", "device", "delay_error_bins"),
]
CONTRASTS_KG_M3 = (3, 10, 30, 50, 100, 170, 240, 300, 450, 600)
N_LAYERS = (1, 2, 5, 10, 20, 50, 100)
N_LENSES = (0, 1, 2, 4, 8, 16)
LAYERING_KG_M3 = (10, 25, 50, 100)
DEFAULT_SLABS, DEFAULT_SLAB_M, MEAN_DENSITY_KG_M3 = 20, 0.25, 450.0
LENS_STACK_KG_M3, LENS_M = 100.0, 0.03
DEPTH_M = 5.0
LOOKS = 32
LONGEST_S = 120e-9  # multiples of twice the depth are still distinguished from first echoes
N_BINS, BINS_ABOVE = 220, 10
TAILS_DB = (10, 15, 20, 25, 30)
SHAPING_DB = 20
SHAPED_BY = {
    "diffuse share": ("diffuse_share", "1", (0.0, 0.0003, 0.0007, 0.002, 0.005)),
    "beam width": ("beamwidth_deg", "degrees", (5.0, 10.0, 20.0, 40.0, 80.0)),
    "height": ("height_m", "m", (250.0, 500.0, 1500.0, 4000.0)),
    "roughness": ("roughness_m", "m", (0.005, 0.02, 0.05, 0.1)),
}
SCENE_LINES = SCENE_BINS = 256
SCENE_LAYERS, SCENE_TOLERANCE_DB = 15, 0.05


def convolution_table(settings, climate, n_looks, stream):
    """A row a model and stack, a tail, a timed scene, a simulated stack; `stream` gives the generator of some keys."""
    rows = [
        row
        for stack in planted_stacks(settings, stream)
        for row in stack_rows(*stack, settings.radar)
    ]
    rows += tail_rows(settings.radar)
    rows += scene_rows(settings, climate, n_looks, rows, stream("scenes"))
    rows += simulation_rows(stream)
    return pd.DataFrame(rows, columns=COLUMNS).assign(device=device_name())


def planted_stacks(settings, stream):
    """Ensembles of stacks: sweep, value, unit, density [kg m-3] and thickness [m] of (look, slab)."""
    radar, firn = settings.radar, settings.firn
    years = partial(
        coherent.draw_years,
        LOOKS,
        mean_density_kg_m3=MEAN_DENSITY_KG_M3,
        roughness_m=radar.roughness_m,
    )
    for contrast in CONTRASTS_KG_M3:
        stack = years(
            DEFAULT_SLABS, float(contrast), slab_m=DEFAULT_SLAB_M, rng=stream("contrast", contrast)
        )
        yield "density contrast", contrast, "kg m-3", *stack
    for n_layers in N_LAYERS:
        slab_m = min(DEFAULT_SLAB_M, DEPTH_M / n_layers)
        stack = years(
            n_layers, firn.horizon_jump_kg_m3, slab_m=slab_m, rng=stream("layers", n_layers)
        )
        yield "layers", n_layers, "1", *stack
    for n_lenses in N_LENSES:
        rng = stream("lenses", n_lenses)
        stack = years(DEFAULT_SLABS, LENS_STACK_KG_M3, slab_m=DEFAULT_SLAB_M, rng=rng)
        yield (
            "ice lenses",
            n_lenses,
            "1",
            *coherent.draw_lenses(*stack, n_lenses, lens_m=LENS_M, rng=rng),
        )
    # Cells of the nature run: a quarter of a range bin in snow of the surface's density.
    density = firn.surface_density_kg_m3
    cell_m = radar.bin_size_s / radar.n_sub_bins / travel_time_s(1.0, density / 1000)
    for sd in LAYERING_KG_M3:
        rng = stream("layering", sd)
        fluctuation = draw_layering(
            LOOKS, int(DEPTH_M / cell_m), cell_m, sd, firn.layering_length_m, rng=rng
        )
        yield "fine layering", sd, "kg m-3", *coherent.layered(fluctuation, density, cell_m)


def stack_rows(sweep, value, unit, density, thickness_m, radar):
    """Errors of all models on one ensemble of stacks under air, and seconds of one look and range line."""
    index = refractive_index_kovacs95(density)
    index = np.concatenate([np.ones((len(index), 1)), index], axis=1)
    delay_s = (np.arange(N_BINS) - BINS_ABOVE) * radar.bin_size_s
    stop_hz = START_FREQUENCY_HZ + radar.bandwidth_hz
    frequency_hz = coherent.sweep_frequencies_hz(START_FREQUENCY_HZ, stop_hz, LONGEST_S)
    works = coherent.model_works(index, thickness_m, frequency_hz, delay_s, radar.bandwidth_hz)
    powers = {}
    timed = {
        name: lambda name=name, work=work: powers.update({name: work()})
        for name, work in works.items()
    }
    seconds = {
        name: seconds / len(index) for name, _, seconds in time_rounds(timed, 1, n_warm_up=0)
    }
    reference = powers["transfer matrix"]
    layers_s = coherent.interface_delays_s(index, thickness_m).mean(axis=0)
    inside = (delay_s >= 0) & (delay_s <= layers_s[-1])
    at_layers = np.unique(np.rint(layers_s[1:] / radar.bin_size_s).astype(int) + BINS_ABOVE)
    at_layers = at_layers[at_layers < N_BINS]
    noise_power = surface_reflectivity(density[0, 0]) * 10 ** (-radar.surface_to_noise_db / 10)
    about = {
        "part": "stacks",
        "sweep": sweep,
        "value": value,
        "unit": unit,
        "reference": "transfer matrix",
    }
    rows = []
    for name in coherent.MODELS:
        row = about | {"method": name, "seconds": seconds[name]}
        row["error_db"] = coherent.error_db(powers[name][inside], reference[inside], noise_power)
        row["layer_error_db"] = coherent.error_db(powers[name][at_layers], reference[at_layers])
        rows.append(row | {"bias_db": coherent.bias_db(powers[name][inside], reference[inside])})
    return rows


def received(radar, rms_slope):
    """Mean echo of one interface as the nature run receives it, by position [bins]."""
    wave = interface_waveform(radar, rms_slope, radar.roughness_m)
    power = np.convolve(wave.power.astype(float), range_response(radar).astype(float) ** 2)
    return np.arange(power.size) / radar.n_sub_bins, power


def tail_rows(radar):
    """What eq. (1) leaves of the nature run's off-nadir tail, by how far down it is followed, and by what shapes it."""
    slopes = {"horizon": radar.horizon_slope, "surface": radar.surface_slope}
    tails = product(slopes.items(), TAILS_DB)
    sweeps = [
        (name, tail_db, "dB below the peak", radar, slope, tail_db)
        for (name, slope), tail_db in tails
    ]
    sweeps += [
        (sweep, value, unit, replace(radar, **{name: value}), radar.horizon_slope, SHAPING_DB)
        for sweep, (name, unit, values) in SHAPED_BY.items()
        for value in values
    ]
    rows = []
    for sweep, value, unit, shaped, slope, tail_db in sweeps:
        fit = fit_waveform(*received(shaped, slope), tail_db)
        about = {"part": "tail", "sweep": sweep, "value": value, "unit": unit}
        about |= {"method": "PHY", "reference": "annuli integral"}
        rows.append(about | {"error_db": fit.rms_db, "layer_error_db": fit.largest_db})
    return rows


def scene_rows(settings, climate, n_looks, rows, rng):
    """Seconds of a scene of 256 x 256 pixels and 15 layers by each model, with the error that `rows` give it."""
    layer_bins, parameters = planted_scene(SCENE_LAYERS, SCENE_LINES, SCENE_BINS, n_looks=n_looks)
    works = {
        "PHY": partial(
            render, layer_bins, parameters, SCENE_BINS, tolerance_db=SCENE_TOLERANCE_DB, rng=rng
        ),
        "PHY, as printed": partial(render_as_printed, layer_bins, parameters, SCENE_BINS, rng=rng),
    }
    runs = time_rounds(works, 3)
    scene = partial(
        draw_scene, 0, "test", climate=climate, settings=settings, n_looks=n_looks, rng=rng
    )
    share = {"nature run": SCENE_LINES * SCENE_BINS / scene().image.size}
    runs += time_rounds({"nature run": scene}, 2, n_warm_up=0)

    def errors(part, sweep, value, method):
        [found] = [
            r
            for r in rows
            if (r["part"], r["sweep"], r["value"], r["method"]) == (part, sweep, value, method)
        ]
        return found

    of_phases = errors("stacks", "layers", DEFAULT_SLABS, "convolution")["error_db"]
    of_phy = np.hypot(errors("tail", "horizon", SHAPING_DB, "PHY")["error_db"], of_phases)
    known = {"PHY": of_phy, "PHY, as printed": of_phy, "nature run": of_phases}
    scenes = [
        ("whole scene", repeat, name, known[name], seconds * share.get(name, 1.0))
        for name, repeat, seconds in runs
    ]
    for method in coherent.MODELS:
        found = errors("stacks", "layers", DEFAULT_SLABS, method)
        seconds = found["seconds"] * SCENE_LINES * n_looks
        scenes.append(
            ("one look and line, extrapolated", 0, f"{method}, stack", found["error_db"], seconds)
        )
    about = {"part": "scene", "unit": "repeat", "reference": "transfer matrix"}
    names = ("sweep", "value", "method", "error_db", "seconds")
    return [about | dict(zip(names, scene, strict=True)) for scene in scenes]
