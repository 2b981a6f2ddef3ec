"""Figures of the flight: an echogram and its picks, a map of the frames, and statistics."""

import numpy as np

from evaluation.lib.figures.style import (
    BLACK,
    GREY,
    GUIDE,
    LAND,
    new_figure,
    new_panel,
)
from snowsim.alignment import layer_bins_of
from snowsim.echogram import to_db
from snowsim.phy.waveform import waveform_exact, waveform_peak

SHOWN_PERCENT = (0.5, 99.9)  # percentiles of power that are black and white
SCALE_KM = 200
DEGREE_KM = 111.2  # of latitude


def echogram(frame, picks, scale):
    """A frame without and with its picks; black where nothing was measured."""
    figure, axes = new_figure(1, 2, width=8, height=4, sharey=True)
    power = frame["Data"].transpose("twtt", "slow_time").values
    power_db = to_db(np.where(power > 0, power, np.nan))
    darkest_db, brightest_db = np.nanpercentile(power_db, SHOWN_PERCENT)
    image = 255 * (power_db - darkest_db) / (brightest_db - darkest_db)
    layer_bins = layer_bins_of(picks, frame)
    surface_bin = np.nanmedian(layer_bins[0])
    bare, picked = axes[0]
    for ax, title in ((bare, "echogram"), (picked, "with picks")):
        ax.set_facecolor(BLACK)
        scale.plot_image(ax, image, surface_bin)
        ax.set(xlabel="along track [km]", title=title)
    scale.plot_layers(picked, layer_bins, surface_bin)
    bare.set_ylabel("depth [m]")
    return figure


def flight_line(frames, coast):
    """Map of Greenland with the mean position of each frame; `coast` has degrees north and east."""
    figure, ax = new_panel(width=4.2, height=5)
    ax.fill("longitude_deg", "latitude_deg", data=coast, facecolor=LAND, edgecolor=GREY)
    positions = [[frame[name].mean() for name in ("Latitude", "Longitude")] for frame in frames]
    latitude, longitude = np.transpose(positions)
    ax.plot(longitude, latitude, "o-", color=BLACK)
    stretch = np.cos(np.radians(latitude.mean()))
    ax.set_aspect(1 / stretch)
    length_deg = SCALE_KM / DEGREE_KM / stretch
    ax.plot([-35, -35 + length_deg], [61, 61], color=BLACK, linewidth=2)
    ax.text(-35 + length_deg / 2, 61.3, f"{SCALE_KM} km", ha="center", fontsize=8)
    ax.set(xlabel="longitude [°E]", ylabel="latitude [°N]", title="Greenland: frames of the flight")
    return figure


def waveforms(statistics):
    """Mean waveform about the surface and the first layer; peak power of all layers."""
    figure, axes = new_figure(1, 3, width=8)
    *of_waveforms, of_peaks = axes[0]
    lag_ns = statistics["lag"] * statistics.attrs["bin_size_s"] * 1e9
    noise_db = to_db(float(statistics["noise_power"]))
    for layer, (name, ax) in enumerate(zip(("the surface", "layer 1"), of_waveforms, strict=True)):
        # Of averaged lines, and of this layer alone by eq. (1).
        mean_db = to_db(statistics["mean_waveform"][layer])
        ax.plot(lag_ns, mean_db, label="all layers and noise")
        ax.plot(lag_ns, to_db(layer_waveform(statistics, layer)), ":", label="this layer alone")
        ax.set(xlabel="two-way travel time [ns]", ylabel="power [dB]", title=f"mean echo at {name}")
        # A layer alone falls by hundreds of decibels above its peak.
        ax.set_ylim(noise_db - 3, float(mean_db.max()) + 3)
        ax.legend()
    of_peaks.plot(to_db(statistics["peak_power"]), "o", color=BLACK)
    of_peaks.axhline(noise_db, label="noise", **GUIDE)
    of_peaks.set(xlabel="layer", ylabel="peak power [dB]", title="strength of every layer")
    of_peaks.legend()
    return figure


def layer_waveform(statistics, layer):
    """Power of a layer alone at the lags of mean waveforms."""
    names = ("variance_bins2", "decay_rate", "offset_bins", "peak_power")
    variance, decay, offset, power = (float(statistics[name][layer]) for name in names)
    peak, height = waveform_peak(variance, decay)
    wave = waveform_exact(statistics["lag"].values - offset + peak, variance, decay)
    return power * wave / height
