"""Waveforms of SMRT's nadir altimetry solver: best fits of eq. (1), and beside the nature run's annuli integral.

SMRT (Picard et al. 2018, Geosci. Model Dev. 11, 2763-2788; its altimetry solver: Larue et al. 2021, Remote Sens.
Environ. 263, 112534) convolves backscatter against depth with Brown's (1977) flat-surface response: geometric optics at
interfaces, volume scattering, and angles of incidence refracted at the surface, which the nature run leaves out: it
takes slopes of buried horizons as they look from the air. SMRT is given the slope divided by the index above. The
nature run's diffuse share has no counterpart there.
"""

import numpy as np
import pandas as pd
from job import job

from lib.diagnostics.phy_errors import fit_waveform
from lib.timing import device_name, time_rounds
from snowsim.constants import CENTRE_FREQUENCY_HZ
from snowsim.io.files import write_table
from snowsim.reference import checked_settings
from snowsim.reference.firn import refractive_index_kovacs95
from snowsim.reference.radar import interface_waveform, range_response

TAILS_DB = (10, 15, 20, 25, 30)
OVERSAMPLING, N_ANGLES, N_GATES, NOMINAL_GATE = 4, 256, 512, 40
BURIED_M, DEEP_M, ICE_GRAIN_M, TEMPERATURE_K = 1.0, 20.0, 1e-4, 250.0
SCENE_LINES = 256


def import_smrt():
    """The package; ValueError with what to do where it is missing."""
    try:
        import smrt
    except ImportError as error:
        msg = "this study needs the package smrt, which is not installed: pip install 'snowsim[studies]'"
        raise ValueError(msg) from error
    return smrt


def altimeter(radar):
    """The radar as SMRT's altimeter; its pulse is a Gaussian of 0.513 / bandwidth."""
    from smrt.core.sensor import Altimeter

    sensor = Altimeter(
        frequency=CENTRE_FREQUENCY_HZ,
        altitude=radar.height_m,
        pulse_bandwidth=radar.bandwidth_hz,
        beamwidth_alongtrack=radar.beamwidth_deg,
        beamwidth_acrosstrack=radar.beamwidth_deg,
        ngate=N_GATES,
        nominal_gate=NOMINAL_GATE,
    )
    sensor.pulse_sigma = 0.513 / radar.bandwidth_hz  # the solver reads it from the sensor
    return sensor


def snowpacks(smrt, settings):
    """Snow under the radar by case: emmodel and snowpack."""
    from smrt.interface.transparent import Transparent

    def rough(slope):
        return smrt.make_interface("geometrical_optics_backscatter", mean_square_slope=slope**2)

    radar, firn = settings.radar, settings.firn
    density = firn.surface_density_kg_m3
    below = density + firn.horizon_jump_kg_m3
    buried = rough(radar.horizon_slope / float(refractive_index_kovacs95(density)))
    grains = {"microstructure_model": "exponential", "corr_length": ICE_GRAIN_M}
    nothing = {"microstructure_model": "homogeneous"}
    two = {"thickness": [BURIED_M, DEEP_M], "density": [density, below]}
    one = {"thickness": [DEEP_M], "density": [density]}
    cases = {
        "surface": ("nonscattering", one | nothing | {"interface": [rough(radar.surface_slope)]}),
        "horizon": ("nonscattering", two | nothing | {"interface": [Transparent, buried]}),
        "volume": ("iba", one | grains | {"interface": [rough(radar.surface_slope)]}),
    }
    made = {}
    for name, (emmodel, keywords) in cases.items():
        pack = smrt.make_snowpack(temperature=TEMPERATURE_K, **keywords)
        pack.sigma_surface = radar.roughness_m
        made[name] = (emmodel, pack)
    return made


def waveform(smrt, emmodel, pack, sensor):
    """SMRT's mean echo on its oversampled gates."""
    options = {
        "oversampling_time": OVERSAMPLING,
        "return_oversampled": True,
        "theta_inc_sampling": N_ANGLES,
        "compute_coherent_reflection": False,  # no specular part, as in the other models
    }
    model = smrt.make_model(emmodel, "nadir_lrm_altimetry", rtsolver_options=options)
    return np.maximum(np.asarray(model.run(sensor, pack).data).squeeze(), 0)


def received(radar, rms_slope):
    """Mean echo of one interface as the nature run receives it, by position [bins]."""
    wave = interface_waveform(radar, rms_slope, radar.roughness_m)
    power = np.convolve(wave.power.astype(float), range_response(radar).astype(float) ** 2)
    return np.arange(power.size) / radar.n_sub_bins, power


def difference_db(x_bins, power, other_x, other_power, tail_db):
    """Root mean square and largest difference of two tails [dB], levels matched on the tail, peak on peak."""
    top, other_top = power.argmax(), other_power.argmax()
    level_db = 10 * np.log10(np.maximum(power, 1e-300))
    end = top + int(np.argmax(level_db[top:] < level_db[top] - tail_db))
    x = x_bins[top:end] - x_bins[top]
    other_db = 10 * np.log10(np.maximum(other_power[other_top:], 1e-300))
    gap = level_db[top:end] - np.interp(x, other_x[other_top:] - other_x[other_top], other_db)
    gap -= gap.mean()
    return float(np.sqrt(np.mean(gap**2))), float(np.abs(gap).max())


def study(path_to_table, path_to_curves, reference):
    smrt = import_smrt()
    settings = checked_settings(reference)
    radar = settings.radar
    sensor = altimeter(radar)
    packs = snowpacks(smrt, settings)
    slopes = {"surface": radar.surface_slope, "horizon": radar.horizon_slope}
    rows, curves = [], []
    about = {"unit": "dB below the peak", "device": device_name()}
    for case, (emmodel, pack) in packs.items():
        power = waveform(smrt, emmodel, pack, sensor)
        x_bins = np.arange(power.size) / (OVERSAMPLING * radar.bandwidth_hz) / radar.bin_size_s
        curves.append(pd.DataFrame({"case": case, "model": "SMRT", "x_bins": x_bins, "power": power / power.max()}))
        for tail_db in TAILS_DB:
            common = {"part": "tail", "sweep": case, "value": tail_db} | about
            fit = fit_waveform(x_bins, power, tail_db)
            numbers = {"error_db": fit.rms_db, "layer_error_db": fit.largest_db, "decay_rate": fit.decay_rate}
            rows.append(common | {"method": "PHY", "reference": "SMRT"} | numbers)
            if case in slopes:
                other = received(radar, slopes[case])
                rms_db, largest_db = difference_db(x_bins, power, *other, tail_db)
                numbers = {"error_db": rms_db, "layer_error_db": largest_db}
                numbers["decay_rate"] = fit_waveform(*other, tail_db).decay_rate
                rows.append(common | {"method": "annuli integral", "reference": "SMRT"} | numbers)
        if case in slopes:
            x_bins, power = received(radar, slopes[case])
            power = power / power.max()
            curves.append(pd.DataFrame({"case": case, "model": "annuli integral", "x_bins": x_bins, "power": power}))
    works = {"SMRT": lambda: waveform(smrt, *packs["horizon"], sensor)}
    [of_tail] = [r["error_db"] for r in rows if (r["sweep"], r["value"], r["method"]) == ("horizon", 20, "PHY")]
    for name, repeat, seconds in time_rounds(works, 3):
        common = {"part": "scene", "sweep": "one waveform, extrapolated", "value": repeat, "method": name} | about
        rows.append(
            common | {"reference": "PHY", "unit": "repeat", "error_db": of_tail, "seconds": seconds * SCENE_LINES}
        )
    write_table(path_to_table, pd.DataFrame(rows))
    write_table(path_to_curves, pd.concat(curves))


if __name__ == "__main__":
    with job(snakemake):
        study(*snakemake.output, **snakemake.params)
