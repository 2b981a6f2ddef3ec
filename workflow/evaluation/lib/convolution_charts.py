"""Accuracy of the convolution model: errors of simpler models and of waveforms, and their cost.

Models are held against a coherent one. Errors are in decibels over thermal noise as far below the
surface as the reference flight has it. Stacks end in air above; looks differ in where each
interface lies, by more than a wavelength there and back.
"""

import time
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pandas as pd

from evaluation.lib import coherent
from evaluation.lib.machine import device_name, time_rounds
from evaluation.lib.phy_alternatives import render_as_printed
from evaluation.lib.phy_errors import fit_waveform, planted_scene
from evaluation.lib.simulation import simulation_rows
from snowsim.constants import START_FREQUENCY_HZ
from snowsim.phy import render
from snowsim.reference import draw_scene
from snowsim.reference.echo import draw_layering
from snowsim.reference.firn import refractive_index_kovacs95, surface_reflectivity, travel_time_s
from snowsim.reference.radar import interface_waveform, range_response

COLUMNS = [
    "part",
    "sweep",
    "value",
    "unit",
    "method",
    "reference",
    "error_db",
    "layer_error_db",
    "bias_db",
    "seconds",
    "device",
    "delay_error_bins",
]
CONTRASTS_KG_M3 = (3, 10, 30, 50, 100, 170, 240, 300, 450, 600)
N_LAYERS = (1, 2, 5, 10, 20, 50, 100)
N_LENSES = (0, 1, 2, 4, 8, 16)
LAYERING_KG_M3 = (10, 25, 50, 100)
DEFAULT_SLABS = 20
DEFAULT_SLAB_M = 0.25
MEAN_DENSITY_KG_M3 = 450.0
LENS_STACK_KG_M3 = 100.0
LENS_M = 0.03
DEPTH_M = 5.0
LOOKS = 32
LONGEST_S = 120e-9  # multiples of twice the depth are still distinguished from first echoes
N_BINS = 220
BINS_ABOVE = 10
TAILS_DB = (10, 15, 20, 25, 30)
SHAPING_DB = 20
SHAPED_BY = {
    "diffuse share": ("diffuse_share", "1", (0.0, 0.0003, 0.0007, 0.002, 0.005)),
    "beam width": ("beamwidth_deg", "degrees", (5.0, 10.0, 20.0, 40.0, 80.0)),
    "height": ("height_m", "m", (250.0, 500.0, 1500.0, 4000.0)),
    "roughness": ("roughness_m", "m", (0.005, 0.02, 0.05, 0.1)),
}
SCENE_LINES = SCENE_BINS = 256
SCENE_LAYERS = 15
SCENE_TOLERANCE_DB = 0.05


@dataclass(frozen=True)
class Sweep:
    """One value of a parameter that is varied."""

    name: str
    value: float
    unit: str

    def row(self, part, method, reference, **numbers):
        """A row of a part of the table."""
        about = {"part": part, "sweep": self.name, "value": self.value, "unit": self.unit}
        return about | {"method": method, "reference": reference} | numbers


def convolution_table(settings, climate, n_looks, stream):
    """A row a model and stack, a tail, a timed scene, a simulated stack.

    `stream` gives the random generator of some keys.
    """
    rows = []
    for sweep, density, thickness_m in planted_stacks(settings, stream):
        rows += stack_rows(sweep, density, thickness_m, settings.radar)
    rows += tail_rows(settings.radar)
    rows += scene_rows(settings, climate, n_looks, pd.DataFrame(rows), stream("scenes"))
    rows += simulation_rows(stream)
    return pd.DataFrame(rows, columns=COLUMNS).assign(device=device_name())


def planted_stacks(settings, stream):
    """Ensembles of stacks: the sweep, density [kg m-3] and thickness [m] of (look, slab)."""
    radar = settings.radar
    firn = settings.firn
    years = partial(
        coherent.draw_years,
        LOOKS,
        mean_density_kg_m3=MEAN_DENSITY_KG_M3,
        roughness_m=radar.roughness_m,
    )
    for contrast in CONTRASTS_KG_M3:
        rng = stream("contrast", contrast)
        stack = years(DEFAULT_SLABS, float(contrast), slab_m=DEFAULT_SLAB_M, rng=rng)
        yield Sweep("density contrast", contrast, "kg m-3"), *stack
    for n_layers in N_LAYERS:
        rng = stream("layers", n_layers)
        slab_m = min(DEFAULT_SLAB_M, DEPTH_M / n_layers)
        stack = years(n_layers, firn.horizon_jump_kg_m3, slab_m=slab_m, rng=rng)
        yield Sweep("layers", n_layers, "1"), *stack
    for n_lenses in N_LENSES:
        rng = stream("lenses", n_lenses)
        stack = years(DEFAULT_SLABS, LENS_STACK_KG_M3, slab_m=DEFAULT_SLAB_M, rng=rng)
        with_lenses = coherent.draw_lenses(*stack, n_lenses, lens_m=LENS_M, rng=rng)
        yield Sweep("ice lenses", n_lenses, "1"), *with_lenses
    # Cells of the nature run: a quarter of a range bin in snow of the surface's density.
    density = firn.surface_density_kg_m3
    cell_m = radar.bin_size_s / radar.n_sub_bins / travel_time_s(1.0, density / 1000)
    n_cells = int(DEPTH_M / cell_m)
    for sd in LAYERING_KG_M3:
        rng = stream("layering", sd)
        fluctuation = draw_layering(LOOKS, n_cells, cell_m, sd, firn.layering_length_m, rng=rng)
        stack = coherent.layered(fluctuation, density, cell_m)
        yield Sweep("fine layering", sd, "kg m-3"), *stack


def stack_rows(sweep, density, thickness_m, radar):
    """Errors of all models on one ensemble of stacks under air, and seconds of a look and line."""
    n_looks = len(density)
    index = refractive_index_kovacs95(density)
    index = np.concatenate([np.ones((n_looks, 1)), index], axis=1)
    delay_s = (np.arange(N_BINS) - BINS_ABOVE) * radar.bin_size_s
    stop_hz = START_FREQUENCY_HZ + radar.bandwidth_hz
    frequency_hz = coherent.sweep_frequencies_hz(START_FREQUENCY_HZ, stop_hz, LONGEST_S)
    works = coherent.model_works(index, thickness_m, frequency_hz, delay_s, radar.bandwidth_hz)

    layers_s = coherent.interface_delays_s(index, thickness_m).mean(axis=0)
    inside = (delay_s >= 0) & (delay_s <= layers_s[-1])
    layer_bins = np.rint(layers_s[1:] / radar.bin_size_s).astype(int)
    at_layers = np.unique(layer_bins + BINS_ABOVE)
    at_layers = at_layers[at_layers < N_BINS]
    noise_power = surface_reflectivity(density[0, 0]) * 10 ** (-radar.surface_to_noise_db / 10)

    rows = []
    reference = None
    for name, work in works.items():
        start = time.perf_counter()
        power = work()
        seconds = time.perf_counter() - start
        if reference is None:
            reference = power  # the transfer matrix comes first
        row = sweep.row("stacks", name, "transfer matrix", seconds=seconds / n_looks)
        row["error_db"] = coherent.error_db(power[inside], reference[inside], noise_power)
        row["layer_error_db"] = coherent.error_db(power[at_layers], reference[at_layers])
        row["bias_db"] = coherent.bias_db(power[inside], reference[inside])
        rows.append(row)
    return rows


def received(radar, rms_slope):
    """Mean echo of one interface as the nature run receives it, by position [bins]."""
    wave = interface_waveform(radar, rms_slope, radar.roughness_m)
    response = range_response(radar).astype(float) ** 2
    power = np.convolve(wave.power.astype(float), response)
    return np.arange(power.size) / radar.n_sub_bins, power


def tail_rows(radar):
    """What eq. (1) leaves of the nature run's off-nadir tail.

    By how far down the tail is followed, and by what shapes it.
    """
    rows = []
    slopes = {"horizon": radar.horizon_slope, "surface": radar.surface_slope}
    for name, slope in slopes.items():
        for tail_db in TAILS_DB:
            sweep = Sweep(name, tail_db, "dB below the peak")
            rows.append(_tail_row(sweep, radar, slope, tail_db))
    for name, (setting, unit, values) in SHAPED_BY.items():
        for value in values:
            shaped = replace(radar, **{setting: value})
            sweep = Sweep(name, value, unit)
            rows.append(_tail_row(sweep, shaped, radar.horizon_slope, SHAPING_DB))
    return rows


def _tail_row(sweep, radar, slope, tail_db):
    fit = fit_waveform(*received(radar, slope), tail_db)
    errors = {"error_db": fit.rms_db, "layer_error_db": fit.largest_db}
    return sweep.row("tail", "PHY", "annuli integral", **errors)


def scene_rows(settings, climate, n_looks, errors, rng):
    """Seconds of a scene of 256 x 256 pixels and 15 layers by each model, with its error.

    `errors` is the table of stacks and tails.
    """
    layer_bins, parameters = planted_scene(SCENE_LAYERS, SCENE_LINES, SCENE_BINS, n_looks=n_looks)
    scene = (layer_bins, parameters, SCENE_BINS)
    works = {
        "PHY": partial(render, *scene, tolerance_db=SCENE_TOLERANCE_DB, rng=rng),
        "PHY, as printed": partial(render_as_printed, *scene, rng=rng),
    }
    runs = time_rounds(works, 3)
    nature_run = partial(
        draw_scene, 0, "test", climate=climate, settings=settings, n_looks=n_looks, rng=rng
    )
    share = SCENE_LINES * SCENE_BINS / nature_run().image.size
    for name, repeat, seconds in time_rounds({"nature run": nature_run}, 2, n_warm_up=0):
        runs.append((name, repeat, seconds * share))

    on_layers = errors[(errors["sweep"] == "layers") & (errors["value"] == DEFAULT_SLABS)]
    on_layers = on_layers.set_index("method")
    tails = errors[(errors["sweep"] == "horizon") & (errors["value"] == SHAPING_DB)]
    of_phases = on_layers.loc["convolution", "error_db"]
    of_phy = np.hypot(tails["error_db"].item(), of_phases)
    known = {"PHY": of_phy, "PHY, as printed": of_phy, "nature run": of_phases}

    rows = []

    def add_row(sweep, method, error_db, seconds):
        numbers = {"error_db": error_db, "seconds": seconds}
        rows.append(sweep.row("scene", method, "transfer matrix", **numbers))

    for name, repeat, seconds in runs:
        add_row(Sweep("whole scene", repeat, "repeat"), name, known[name], seconds)
    sweep = Sweep("one look and line, extrapolated", 0, "repeat")
    for method, row in on_layers.iterrows():
        seconds = row["seconds"] * SCENE_LINES * n_looks
        add_row(sweep, f"{method}, stack", row["error_db"], seconds)
    return rows
