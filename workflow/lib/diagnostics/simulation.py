"""What `snowsim.simulate` makes of snow against a coherent solver, and its tails against the integral over annuli."""

from dataclasses import replace

import numpy as np
from scipy.special import ndtri

from lib.diagnostics import coherent
from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.phy import mean_power
from snowsim.physical import PRESETS, Snowpack, physical_parameters
from snowsim.reference.firn import refractive_index_kovacs95
from snowsim.reference.radar import annulus_power

N_LOOKS, N_INTERFACES, N_SHIFTS = 512, 6, 8
MEAN_DENSITY_KG_M3 = 450.0
CONTRASTS_KG_M3 = (3, 10, 30, 100, 170, 250, 350, 500, 700)
SPACINGS = (0.75, 1, 1.5, 2, 3, 5, 8)
CONTRAST_KG_M3, SPACING = 250, 3  # of the other sweep: the limits of what is claimed
SLOPES, BEAMS_DEG, TAIL_DB = (0.01, 0.03, 0.1, 0.2, 0.3, 0.5), (2, 5, 10, 20, 40, 80), 20.0
ROUGH_SLOPE = 0.5  # of the sweep of beams: the beam ends the tail
DIFFUSE_SHARES = (0.0, 0.0007)  # none, and the reference flight's


def simulation_rows(stream):
    """A row a radar and stack, and a row a tail; `stream` gives the random generator of some keys."""
    stacks = [("contrast", "kg m-3", c, (c, SPACING)) for c in CONTRASTS_KG_M3]
    stacks += [("spacing", "range cells", s, (CONTRAST_KG_M3, s)) for s in SPACINGS]
    rows = []
    for name, radar in PRESETS.items():
        for sweep, unit, value, stack in stacks:
            bins, error_db = solver_errors(
                radar, *stack, rng=stream("simulate", name, sweep, value)
            )
            about = {
                "part": "simulate",
                "sweep": sweep,
                "value": value,
                "unit": unit,
                "method": name,
            }
            errors = {"error_db": np.abs(error_db).max(), "delay_error_bins": np.abs(bins).max()}
            rows.append(about | errors | {"reference": "transfer matrix"})
    wide = PRESETS["snow-2-8"]
    tails = [("slope", "1", s, wide, s) for s in SLOPES]
    tails += [
        ("beam", "degrees", b, replace(wide, beamwidth_deg=b), ROUGH_SLOPE) for b in BEAMS_DEG
    ]
    for sweep, unit, value, radar, slope in tails:
        for share in DIFFUSE_SHARES:
            about = {"part": "decay", "sweep": sweep, "value": value, "unit": unit}
            about["method"] = f"diffuse share {share:g}"
            errors = {"error_db": tail_error_db(radar, slope, diffuse_share=share)}
            rows.append(about | errors | {"reference": "annuli integral"})
    return rows


def solver_errors(radar, contrast_kg_m3, spacing, *, rng):
    """Errors of delay [bins] and mean power [dB], (layer,), against the transfer matrix, mean over random phases.

    Interfaces lie `spacing` range cells apart, the contrast turns its sign from one to the next.
    """
    radar = replace(
        radar, height_m=1e6, widening=1.0
    )  # a plane wave and the window's own response, as the solver's
    n = np.arange(N_INTERFACES)
    density = MEAN_DENSITY_KG_M3 + np.where(n % 2, 0.5, -0.5) * contrast_kg_m3
    index = refractive_index_kovacs95(density)
    cell_m = radar.cell_s * SPEED_OF_LIGHT_M_S / 2
    depth_m = np.concatenate([[0], np.cumsum(spacing * cell_m / index[:-1])])
    # In every look anew, an eighth of the wavelength in all: phases there and back scatter by half
    # a turn.
    rough_m = np.where(n > 0, SPEED_OF_LIGHT_M_S / radar.centre_hz / 8, 0.0)
    normals = rng.permuted(
        np.tile(ndtri((np.arange(N_LOOKS) + 0.5) / N_LOOKS), (n.size, 1)), axis=1
    ).T
    at_m = np.maximum.accumulate(depth_m + rough_m * normals, axis=1)
    below_s, parameters = physical_parameters(
        Snowpack(depth_m, density, rough_m, slope=1e-5), radar
    )

    step = radar.bin_s / N_SHIFTS
    margin = int(np.ceil(3 * radar.cell_s / radar.bin_s))
    n_bins = 2 * margin + int(np.ceil(below_s[-1, 0] / radar.bin_s))
    shifts = np.arange(N_SHIFTS) / N_SHIFTS
    layer_bins = margin + below_s / radar.bin_s - shifts
    power = np.tile(parameters.pop("peak_power"), N_SHIFTS)
    phy = mean_power(
        layer_bins, power, **parameters, n_range_bins=n_bins, normalise="none", align="gaussian"
    ).ravel()

    delay_s = (np.arange(n_bins * N_SHIFTS) - margin * N_SHIFTS) * step
    media = np.tile(np.concatenate([[1], index]), (N_LOOKS, 1))
    frequency_hz = radar.centre_hz + radar.bandwidth_hz * np.array([-0.5, 0.5])
    frequency_hz = coherent.sweep_frequencies_hz(*frequency_hz, 4 * (delay_s[-1] - delay_s[0]))
    reflection, _ = coherent.reflect(media, np.diff(at_m, axis=1), frequency_hz)
    solver = coherent.mean_profile(reflection, frequency_hz, delay_s)
    found = [_peaks(profile, delay_s, below_s[:, 0], radar.cell_s) for profile in (phy, solver)]
    (phy_s, phy_power), (solver_s, solver_power) = found
    return (phy_s - solver_s) / radar.bin_s, 10 * np.log10(phy_power / solver_power)


def _peaks(profile, delay_s, layers_s, cell_s):
    """Where a profile peaks within half a cell of each layer [s], and its power there."""
    peaks = []
    for layer_s in layers_s:
        near = np.flatnonzero(np.abs(delay_s - layer_s) <= cell_s / 2)
        top = near[profile[near].argmax()]
        left, middle, right = profile[top - 1 : top + 2]
        peaks_there = middle >= max(left, right)  # else a neighbour's flank hides it
        away = 0.5 * (left - right) / (left - 2 * middle + right) if peaks_there else 0.0
        peaks.append(
            (delay_s[top] + away * (delay_s[1] - delay_s[0]), middle - 0.25 * (left - right) * away)
        )
    return np.array(peaks).T


def tail_error_db(radar, slope, *, diffuse_share=0.0, tail_db=TAIL_DB):
    """Largest error [dB] of the exponential tail against the annuli, until these have fallen by `tail_db`."""
    rate, _ = radar.tail(slope, radar.height_m)
    delay_s = np.linspace(0, 3 * tail_db / 4.34 / rate, 3000)
    annuli = annulus_power(delay_s, radar.height_m, slope, diffuse_share, radar.beamwidth_deg)
    level_db = 10 * np.log10(annuli / annuli[0])
    first = int(np.argmax(level_db < -tail_db)) or delay_s.size
    return float(np.abs(level_db + 10 / np.log(10) * rate * delay_s)[:first].max())
