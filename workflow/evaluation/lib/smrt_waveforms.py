"""Waveforms of SMRT's nadir altimetry solver beside those of eq. (1) and of the nature run.

Eq. (1) is fitted at best; the nature run integrates over annuli. SMRT: Picard et al. (2018),
Geosci. Model Dev. 11, 2763-2788; the solver: Larue et al. (2021), Remote Sens. Environ. 263,
112534. It refracts angles of incidence at the surface, where the nature run takes slopes of buried
horizons as they look from the air: SMRT is given the slope divided by the index above. The diffuse
share has no counterpart there.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from evaluation.lib.convolution_charts import SCENE_LINES, SHAPING_DB, TAILS_DB, Sweep, received
from evaluation.lib.machine import device_name, time_rounds
from evaluation.lib.phy_errors import fit_waveform
from snowsim.constants import CENTRE_FREQUENCY_HZ
from snowsim.reference.firn import refractive_index_kovacs95

OVERSAMPLING = 4
N_ANGLES = 256
N_GATES = 512
NOMINAL_GATE = 40
BURIED_M = 1.0
DEEP_M = 20.0
ICE_GRAIN_M = 1e-4
TEMPERATURE_K = 250.0
COLUMNS = [
    "part",
    "sweep",
    "value",
    "unit",
    "device",
    "method",
    "reference",
    "error_db",
    "layer_error_db",
    "decay_rate",
    "seconds",
]


@dataclass(frozen=True)
class Echo:
    """A mean echo: power at increasing positions [bins]."""

    x_bins: np.ndarray
    power: np.ndarray

    def from_peak(self):
        """Positions from the peak on [bins], and level there [dB]."""
        top = self.power.argmax()
        level_db = 10 * np.log10(np.maximum(self.power[top:], 1e-300))
        return self.x_bins[top:] - self.x_bins[top], level_db


def import_smrt():
    """The package; ValueError with what to do where it is missing."""
    try:
        import smrt
    except ImportError as error:
        msg = (
            "this study needs the package smrt, which is not installed: "
            "pip install 'snowsim[studies]'"
        )
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

    def pack(**layers):
        made = smrt.make_snowpack(temperature=TEMPERATURE_K, **layers)
        made.sigma_surface = radar.roughness_m
        return made

    radar = settings.radar
    density = settings.firn.surface_density_kg_m3
    below = density + settings.firn.horizon_jump_kg_m3
    air_to_snow = float(refractive_index_kovacs95(density))
    surface = pack(
        thickness=[DEEP_M],
        density=[density],
        microstructure_model="homogeneous",
        interface=[rough(radar.surface_slope)],
    )
    horizon = pack(
        thickness=[BURIED_M, DEEP_M],
        density=[density, below],
        microstructure_model="homogeneous",
        interface=[Transparent, rough(radar.horizon_slope / air_to_snow)],
    )
    volume = pack(
        thickness=[DEEP_M],
        density=[density],
        microstructure_model="exponential",
        corr_length=ICE_GRAIN_M,
        interface=[rough(radar.surface_slope)],
    )
    return {
        "surface": ("nonscattering", surface),
        "horizon": ("nonscattering", horizon),
        "volume": ("iba", volume),
    }


def waveform(smrt, emmodel, pack, sensor):
    """SMRT's mean echo on its oversampled gates."""
    options = {
        "oversampling_time": OVERSAMPLING,
        "return_oversampled": True,
        "theta_inc_sampling": N_ANGLES,
        "compute_coherent_reflection": False,  # no specular part, as in the other models
    }
    model = smrt.make_model(emmodel, "nadir_lrm_altimetry", rtsolver_options=options)
    power = np.asarray(model.run(sensor, pack).data)
    return np.maximum(power.squeeze(), 0)


def difference_db(echo, other, tail_db):
    """Root mean square and largest difference of two tails [dB].

    Levels are matched on the tail, peak on peak.
    """
    x_bins, level_db = echo.from_peak()
    end = int(np.argmax(level_db < level_db[0] - tail_db))
    gap = level_db[:end] - np.interp(x_bins[:end], *other.from_peak())
    gap -= gap.mean()
    return float(np.sqrt(np.mean(gap**2))), float(np.abs(gap).max())


def compare_waveforms(settings):
    """Two tables: errors of eq. (1) and of the annuli integral against SMRT; the waveforms.

    Seconds are those of SMRT.
    """
    smrt = import_smrt()
    radar = settings.radar
    sensor = altimeter(radar)
    packs = snowpacks(smrt, settings)
    slopes = {"surface": radar.surface_slope, "horizon": radar.horizon_slope}
    rows = []
    curves = []
    for case, (emmodel, pack) in packs.items():
        power = waveform(smrt, emmodel, pack, sensor)
        gate_bins = np.arange(power.size) / (OVERSAMPLING * radar.bandwidth_hz) / radar.bin_size_s
        of_smrt = Echo(gate_bins, power)
        annuli = Echo(*received(radar, slopes[case])) if case in slopes else None
        curves.append(curve(case, "SMRT", of_smrt))
        rows += tail_rows(case, of_smrt, annuli)
        if annuli is not None:
            curves.append(curve(case, "annuli integral", annuli))
    table = pd.DataFrame(rows)
    horizon = (table["sweep"] == "horizon") & (table["method"] == "PHY")
    error_db = table.loc[horizon & (table["value"] == SHAPING_DB), "error_db"].item()
    works = {"SMRT": lambda: waveform(smrt, *packs["horizon"], sensor)}
    for name, repeat, seconds in time_rounds(works, 3):
        sweep = Sweep("one waveform, extrapolated", repeat, "repeat")
        numbers = {"error_db": error_db, "seconds": seconds * SCENE_LINES}
        rows.append(sweep.row("scene", name, "PHY", **numbers))
    table = pd.DataFrame(rows).assign(device=device_name())
    return table[COLUMNS], pd.concat(curves)


def curve(case, model, echo):
    """An echo as rows of the table of waveforms."""
    relative = echo.power / echo.power.max()
    return pd.DataFrame({"case": case, "model": model, "x_bins": echo.x_bins, "power": relative})


def tail_rows(case, of_smrt, annuli):
    """Errors of the tail of SMRT's echo, by how far down it is followed."""
    rows = []
    for tail_db in TAILS_DB:
        sweep = Sweep(case, tail_db, "dB below the peak")
        fit = fit_waveform(of_smrt.x_bins, of_smrt.power, tail_db)
        row = sweep.row("tail", "PHY", "SMRT", decay_rate=fit.decay_rate)
        rows.append(row | {"error_db": fit.rms_db, "layer_error_db": fit.largest_db})
        if annuli is not None:
            fit = fit_waveform(annuli.x_bins, annuli.power, tail_db)
            row = sweep.row("tail", "annuli integral", "SMRT", decay_rate=fit.decay_rate)
            rms_db, largest_db = difference_db(of_smrt, annuli, tail_db)
            rows.append(row | {"error_db": rms_db, "layer_error_db": largest_db})
    return rows
