"""What `snowsim.simulate` makes of snow against a coherent solver, and tails against annuli."""

from dataclasses import replace
from functools import partial

import numpy as np
from scipy.special import ndtri

from evaluation.lib import coherent
from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.phy import mean_power
from snowsim.physical import PRESETS, Snowpack, physical_parameters
from snowsim.reference.firn import refractive_index_kovacs95
from snowsim.reference.radar import annulus_power

N_LOOKS = 512
N_INTERFACES = 6
N_SHIFTS = 8  # of the grid of range bins, to sample mean power between them
MEAN_DENSITY_KG_M3 = 450.0
CONTRASTS_KG_M3 = (3, 10, 30, 100, 170, 250, 350, 500, 700)
SPACINGS = (0.75, 1, 1.5, 2, 3, 5, 8)
# Of the other sweep: the limits of what is claimed.
CONTRAST_KG_M3 = 250
SPACING = 3
SLOPES = (0.01, 0.03, 0.1, 0.2, 0.3, 0.5)
BEAMS_DEG = (2, 5, 10, 20, 40, 80)
TAIL_DB = 20.0
ROUGH_SLOPE = 0.5  # of the sweep of beams: the beam ends the tail
DIFFUSE_SHARES = (0.0, 0.0007)  # none, and the reference flight's


def simulation_rows(stream):
    """A row a radar and stack, and a row a tail; `stream` gives the generator of some keys."""
    rows = []
    for name, radar in PRESETS.items():
        row_of = partial(_solver_row, stream, name, radar)
        for contrast in CONTRASTS_KG_M3:
            rows.append(row_of("contrast", "kg m-3", contrast, contrast, SPACING))
        for spacing in SPACINGS:
            rows.append(row_of("spacing", "range cells", spacing, CONTRAST_KG_M3, spacing))
    wide = PRESETS["snow-2-8"]
    for slope in SLOPES:
        rows += _tail_rows("slope", "1", slope, wide, slope)
    for beam_deg in BEAMS_DEG:
        radar = replace(wide, beamwidth_deg=beam_deg)
        rows += _tail_rows("beam", "degrees", beam_deg, radar, ROUGH_SLOPE)
    return rows


def _solver_row(stream, name, radar, sweep, unit, value, contrast_kg_m3, spacing):
    rng = stream("simulate", name, sweep, value)
    bins, error_db = solver_errors(radar, contrast_kg_m3, spacing, rng=rng)
    return {
        "part": "simulate",
        "sweep": sweep,
        "value": value,
        "unit": unit,
        "method": name,
        "error_db": np.abs(error_db).max(),
        "delay_error_bins": np.abs(bins).max(),
        "reference": "transfer matrix",
    }


def _tail_rows(sweep, unit, value, radar, slope):
    return [
        {
            "part": "decay",
            "sweep": sweep,
            "value": value,
            "unit": unit,
            "method": f"diffuse share {share:g}",
            "error_db": tail_error_db(radar, slope, diffuse_share=share),
            "reference": "annuli integral",
        }
        for share in DIFFUSE_SHARES
    ]


def solver_errors(radar, contrast_kg_m3, spacing, *, rng):
    """Errors of delay [bins] and mean power [dB], (layer,), against the transfer matrix.

    Of the mean over random phases. Interfaces lie `spacing` range cells apart, the contrast turns
    its sign from one to the next.
    """
    # A plane wave and the window's own response, as the solver's.
    radar = replace(radar, height_m=1e6, widening=1.0)
    snowpack = _stack(radar, contrast_kg_m3, spacing)
    below_s, parameters = physical_parameters(snowpack, radar)
    margin = int(np.ceil(3 * radar.cell_s / radar.bin_s))
    n_bins = 2 * margin + int(np.ceil(below_s[-1, 0] / radar.bin_s))
    step_s = radar.bin_s / N_SHIFTS
    delay_s = (np.arange(n_bins * N_SHIFTS) - margin * N_SHIFTS) * step_s

    shifts = np.arange(N_SHIFTS) / N_SHIFTS
    parameters["peak_power"] = np.tile(parameters["peak_power"], N_SHIFTS)
    phy = mean_power(
        margin + below_s / radar.bin_s - shifts,
        **parameters,
        n_range_bins=n_bins,
        normalise="none",
        align="gaussian",
    )
    solver = _solved(radar, snowpack, delay_s, rng)
    phy_s, phy_power = _peaks(phy.ravel(), delay_s, below_s[:, 0], radar.cell_s)
    solver_s, solver_power = _peaks(solver, delay_s, below_s[:, 0], radar.cell_s)
    return (phy_s - solver_s) / radar.bin_s, 10 * np.log10(phy_power / solver_power)


def _stack(radar, contrast_kg_m3, spacing):
    """Interfaces `spacing` range cells apart; phases below the surface scatter by half a turn."""
    number = np.arange(N_INTERFACES)
    density = MEAN_DENSITY_KG_M3 + np.where(number % 2, 0.5, -0.5) * contrast_kg_m3
    cell_m = radar.cell_s * SPEED_OF_LIGHT_M_S / 2
    slab_m = spacing * cell_m / refractive_index_kovacs95(density[:-1])
    depth_m = np.concatenate([[0], np.cumsum(slab_m)])
    # There and back: an eighth of the wavelength in all.
    rough_m = np.where(number > 0, SPEED_OF_LIGHT_M_S / radar.centre_hz / 8, 0.0)
    return Snowpack(depth_m, density, rough_m, slope=1e-5, coherent=False)


def _solved(radar, snowpack, delay_s, rng):
    """Mean power by the transfer matrix, (delay,), each look with rough interfaces of its own."""
    levels = (np.arange(N_LOOKS) + 0.5) / N_LOOKS
    normals = rng.permuted(np.tile(ndtri(levels), (N_INTERFACES, 1)), axis=1).T
    rough_m = snowpack.depth_m[:, 0] + snowpack.roughness_m * normals
    thickness_m = np.diff(np.maximum.accumulate(rough_m, axis=1), axis=1)
    index = refractive_index_kovacs95(snowpack.density_kg_m3[:, 0])
    media = np.tile(np.concatenate([[1], index]), (N_LOOKS, 1))
    ends_hz = radar.centre_hz + radar.bandwidth_hz * np.array([-0.5, 0.5])
    longest_s = 4 * (delay_s[-1] - delay_s[0])
    frequency_hz = coherent.sweep_frequencies_hz(*ends_hz, longest_s)
    reflection, _ = coherent.reflect(media, thickness_m, frequency_hz)
    return coherent.mean_profile(reflection, frequency_hz, delay_s)


def _peaks(profile, delay_s, layers_s, cell_s):
    """Where a profile peaks within half a cell of each layer [s], and its power there."""
    step_s = delay_s[1] - delay_s[0]
    peaks_s = np.empty(len(layers_s))
    power = np.empty(len(layers_s))
    for layer, layer_s in enumerate(layers_s):
        near = np.flatnonzero(np.abs(delay_s - layer_s) <= cell_s / 2)
        top = near[profile[near].argmax()]
        left, middle, right = profile[top - 1 : top + 2]
        away = 0.0
        # Else a neighbour's flank hides it.
        if middle >= max(left, right):
            away = 0.5 * (left - right) / (left - 2 * middle + right)
        peaks_s[layer] = delay_s[top] + away * step_s
        power[layer] = middle - 0.25 * (left - right) * away
    return peaks_s, power


def tail_error_db(radar, slope, *, diffuse_share=0.0):
    """Largest error [dB] of the exponential tail against the annuli, over their first `TAIL_DB`."""
    rate, _ = radar.tail(slope, radar.height_m)
    delay_s = np.linspace(0, 3 * TAIL_DB / 4.34 / rate, 3000)
    annuli = annulus_power(delay_s, radar.height_m, slope, diffuse_share, radar.beamwidth_deg)
    level_db = 10 * np.log10(annuli / annuli[0])
    fallen = np.argmax(level_db < -TAIL_DB) or delay_s.size
    error_db = level_db + 10 / np.log(10) * rate * delay_s
    return float(np.abs(error_db)[:fallen].max())
