"""Waveforms of SMRT's nadir altimetry solver beside best fits of eq. (1) and the nature run's annuli integral.

Picard et al. (2018), Geosci. Model Dev. 11, 2763-2788; the solver: Larue et al. (2021), Remote
Sens. Environ. 263, 112534. It refracts angles of incidence at the surface, where the nature run
takes slopes of buried horizons as they look from the air: SMRT is given the slope divided by the
index above. The diffuse share has no counterpart there.
"""

import numpy as np
import pandas as pd

from lib.diagnostics.convolution_charts import SCENE_LINES, SHAPING_DB, TAILS_DB, received
from lib.diagnostics.phy_errors import fit_waveform
from lib.machine import device_name, time_rounds
from snowsim.constants import CENTRE_FREQUENCY_HZ
from snowsim.reference.firn import refractive_index_kovacs95

OVERSAMPLING, N_ANGLES, N_GATES, NOMINAL_GATE = 4, 256, 512, 40
BURIED_M, DEEP_M, ICE_GRAIN_M, TEMPERATURE_K = 1.0, 20.0, 1e-4, 250.0


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
    buried = rough(radar.horizon_slope / float(refractive_index_kovacs95(density)))
    grains = {"microstructure_model": "exponential", "corr_length": ICE_GRAIN_M}
    nothing = {"microstructure_model": "homogeneous"}
    two = {"thickness": [BURIED_M, DEEP_M], "density": [density, density + firn.horizon_jump_kg_m3]}
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
    }
    options["compute_coherent_reflection"] = False  # no specular part, as in the other models
    model = smrt.make_model(emmodel, "nadir_lrm_altimetry", rtsolver_options=options)
    return np.maximum(np.asarray(model.run(sensor, pack).data).squeeze(), 0)


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


def compare_waveforms(settings):
    """Errors of eq. (1) and of the annuli integral against SMRT, seconds of SMRT; and the waveforms: two tables."""
    smrt, radar = import_smrt(), settings.radar
    sensor, packs = altimeter(radar), snowpacks(smrt, settings)
    slopes = {"surface": radar.surface_slope, "horizon": radar.horizon_slope}
    rows, curves = [], []

    def add_curve(case, model, x_bins, power):
        curves.append(
            pd.DataFrame(
                {"case": case, "model": model, "x_bins": x_bins, "power": power / power.max()}
            )
        )

    for case, (emmodel, pack) in packs.items():
        power = waveform(smrt, emmodel, pack, sensor)
        x_bins = np.arange(power.size) / (OVERSAMPLING * radar.bandwidth_hz) / radar.bin_size_s
        other = received(radar, slopes[case]) if case in slopes else None
        add_curve(case, "SMRT", x_bins, power)
        for tail_db in TAILS_DB:
            fit = fit_waveform(x_bins, power, tail_db)
            found = {"PHY": (fit.rms_db, fit.largest_db, fit.decay_rate)}
            if other is not None:
                rate = fit_waveform(*other, tail_db).decay_rate
                found["annuli integral"] = (*difference_db(x_bins, power, *other, tail_db), rate)
            about = {
                "part": "tail",
                "sweep": case,
                "value": tail_db,
                "unit": "dB below the peak",
                "reference": "SMRT",
            }
            names = ("method", "error_db", "layer_error_db", "decay_rate")
            rows += [
                about | dict(zip(names, (method, *numbers), strict=True))
                for method, numbers in found.items()
            ]
        if other is not None:
            add_curve(case, "annuli integral", *other)
    works = {"SMRT": lambda: waveform(smrt, *packs["horizon"], sensor)}
    [of_tail] = [
        row["error_db"]
        for row in rows
        if (row["sweep"], row["value"], row["method"]) == ("horizon", SHAPING_DB, "PHY")
    ]
    for name, repeat, seconds in time_rounds(works, 3):
        about = {
            "part": "scene",
            "sweep": "one waveform, extrapolated",
            "value": repeat,
            "unit": "repeat",
        }
        numbers = {
            "method": name,
            "reference": "PHY",
            "error_db": of_tail,
            "seconds": seconds * SCENE_LINES,
        }
        rows.append(about | numbers)
    columns = [
        "part",
        "sweep",
        "value",
        "unit",
        "device",
        "method",
        "reference",
        "error_db",
        "layer_error_db",
    ]
    table = pd.DataFrame(rows).assign(device=device_name())
    return table[[*columns, "decay_rate", "seconds"]], pd.concat(curves)
