"""Random profiles of snow, as `snowsim.simulate` combines their interfaces, and a coherent solver.

Cells of half a metre are compared, where the snow and not the surface makes the echo.
"""

import time
import warnings
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from evaluation.lib import coherent
from snowsim.constants import ICE_DENSITY_KG_M3
from snowsim.echogram import to_db
from snowsim.phy import mean_power
from snowsim.physical import MOST_LOST_DB, PRESETS, Snowpack, physical_parameters
from snowsim.profile import combine
from snowsim.reference.firn import refractive_index_kovacs95

# 600-900 MHz, 2-8, 12-18 and 2-18 GHz.
BANDS = ("accumulation", "snow-2-8", "ku-12-18", "snow-2-18")
DEPTH_M = 4.0
CELL_M = 0.5
STEPS_M = (0.001, 0.2)
SDS_KG_M3 = (10.0, 60.0)
LENSES_M = (0.002, 0.05)
N_LENSES = 3
SURFACE_KG_M3 = 340.0
GRADIENT_KG_M4 = 20.0
SAMPLES = 6  # of power, to a range cell
CLEAR_DB = -10.0  # the surface's own echo, of the solver's power; above, a cell is left out
LONGEST = 2.5  # of the sweep's unambiguous travel time, over that to the base


@dataclass(frozen=True)
class Kind:
    """What a profile is drawn from; no lenses where they have no thickness."""

    step_m: float
    sd_kg_m3: float
    lens_m: float


def draw_kind(rng):
    """A kind of profile: step and lenses even in their logarithm, every other without lenses."""
    step_m = np.exp(rng.uniform(*np.log(STEPS_M)))
    lens_m = np.exp(rng.uniform(*np.log(LENSES_M)))
    return Kind(step_m, rng.uniform(*SDS_KG_M3), lens_m * rng.integers(2))


def draw_profile(kind, *, rng):
    """`Snowpack` of steps of random density, denser with depth, and of lenses of ice in it."""
    n_steps = round(DEPTH_M / kind.step_m)
    depth_m = np.arange(n_steps) * kind.step_m
    mean = SURFACE_KG_M3 + GRADIENT_KG_M4 * depth_m
    density = mean + kind.sd_kg_m3 * rng.standard_normal(n_steps)
    if kind.lens_m:
        for top_m in np.sort(rng.uniform(CELL_M, DEPTH_M - CELL_M, N_LENSES)):
            depth_m, density = with_lens(depth_m, density, top_m, kind.lens_m)
    density = np.clip(density, coherent.LOW_KG_M3, ICE_DENSITY_KG_M3)
    return Snowpack(depth_m, density, roughness_m=0.0, slope=1e-5, coherent=True)


def with_lens(depth_m, density, top_m, lens_m):
    """Interfaces and the density below each, ice from `top_m` on."""
    base_m = top_m + lens_m
    below = density[np.searchsorted(depth_m, base_m, side="right") - 1]
    kept = (depth_m < top_m) | (depth_m > base_m)
    depth_m = np.append(depth_m[kept], [top_m, base_m])
    density = np.append(density[kept], [ICE_DENSITY_KG_M3, below])
    order = np.argsort(depth_m)
    return depth_m[order], density[order]


def cell_errors(snowpack, radar):
    """Errors of mean power [dB] of each cell against the solver, a table of cells.

    `error_db` of what `simulate` renders, `in_power_db` of the sum of all interfaces' powers,
    `surface_db` what of the solver's power is the surface's own, `lost_db` what reflections above
    take. A plane wave and the window's own response, as the solver's.
    """
    radar = replace(radar, height_m=1e6, widening=1.0, bin_s=radar.cell_s / SAMPLES)
    in_power = replace(snowpack, coherent=False)
    at_s, alone = physical_parameters(in_power, radar)
    n_bins = int(at_s[-1, 0] / radar.bin_s)
    delay_s = np.arange(n_bins) * radar.bin_s
    cell = (np.interp(delay_s, at_s[:, 0], snowpack.depth_m[:, 0]) / CELL_M).astype(int)
    n_samples = np.bincount(cell)

    start = time.perf_counter()
    below_s, parameters = physical_parameters(snowpack, radar)
    seconds = time.perf_counter() - start
    rendered = mean_power(
        below_s / radar.bin_s,
        **parameters,
        n_range_bins=n_bins,
        normalise="none",
        align="gaussian",
    )
    start = time.perf_counter()
    solved = solved_power(snowpack, radar, delay_s)
    solver_seconds = time.perf_counter() - start
    surface = solved_power(surface_of(snowpack), radar, delay_s)
    cell_s = np.bincount(cell, delay_s) / n_samples
    of_cells = [np.bincount(cell, power) for power in (rendered[:, 0], solved, surface)]
    rendered, solved, surface = (power / n_samples for power in of_cells)
    return pd.DataFrame(
        {
            "depth_m": CELL_M * np.arange(n_samples.size),
            "error_db": to_db(rendered / solved),
            "in_power_db": to_db(summed_power(at_s, alone, radar, cell, delay_s) / solved),
            "surface_db": to_db(surface / solved),
            "lost_db": np.interp(cell_s, *lost_by_delay(snowpack, radar)),
            "n_interfaces": len(at_s),
            "n_reflectors": len(below_s),
            "seconds": seconds,
            "solver_seconds": solver_seconds,
        }
    )


def summed_power(at_s, parameters, radar, cell, delay_s):
    """Mean power of cells, (cell,), where each echo has its area at its interface."""
    width = np.sqrt(2 * np.pi * parameters["variance_bins2"]) / parameters["decay_rate"]
    area = parameters["peak_power"][:, 0] * width
    inside = at_s[:, 0] < delay_s[-1]
    sample = (at_s[inside, 0] / radar.bin_s).astype(int)
    total = np.bincount(cell[sample], area[inside], minlength=cell[-1] + 1)
    return total / np.bincount(cell)


def lost_by_delay(snowpack, radar):
    """Travel time of reflectors [s], and what is lost above them on the way down and up [dB]."""
    index = np.append(1, refractive_index_kovacs95(snowpack.density_kg_m3[:, 0]))
    thickness_m = np.diff(snowpack.depth_m[:, 0])
    reflection = coherent.fresnel(index[:-1], index[1:])
    delay_s = coherent.interface_delays_s(index, thickness_m)
    found = combine(delay_s, reflection, radar.sweep)
    return found.delay_s, found.lost_db


def surface_of(snowpack):
    """Snow of the uppermost density, without an interface in it."""
    return Snowpack(snowpack.depth_m[:1], snowpack.density_kg_m3[:1])


def solved_power(snowpack, radar, delay_s):
    """Power by the transfer matrix, every multiple included, (delay,)."""
    index = np.append(1, refractive_index_kovacs95(snowpack.density_kg_m3[:, 0]))
    thickness_m = np.diff(snowpack.depth_m[:, 0])
    ends_hz = radar.centre_hz + radar.bandwidth_hz * np.array([-0.5, 0.5])
    frequency_hz = coherent.sweep_frequencies_hz(*ends_hz, LONGEST * delay_s[-1])
    reflection, _ = coherent.reflect(index[None], thickness_m[None], frequency_hz)
    return coherent.mean_profile(reflection, frequency_hz, delay_s)


def profile_table(n_profiles, stream):
    """A row a cell, band and profile; `stream` gives the generator of some keys."""
    tables = []
    for number in range(n_profiles):
        rng = stream("profiles", number)
        kind = draw_kind(rng)
        snowpack = draw_profile(kind, rng=rng)
        for name in BANDS:
            with warnings.catch_warnings():
                # Of multiples: what is lost is a column.
                warnings.simplefilter("ignore", UserWarning)
                cells = cell_errors(snowpack, PRESETS[name])
            tables.append(cells.assign(profile=number, radar=name, **vars(kind)))
    return pd.concat(tables, ignore_index=True)


def compared(table):
    """Whole cells where the snow makes the echo and no warning tells of multiples."""
    whole = table["depth_m"] + CELL_M <= DEPTH_M + 1e-9
    clear = table["surface_db"] < CLEAR_DB
    return table[whole & clear & (table["lost_db"] < MOST_LOST_DB)]
