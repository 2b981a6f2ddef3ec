"""The flight: an echogram and its picks, where its frames lie, and its statistics."""

import numpy as np
import pandas as pd

from evaluation.lib.figures.style import (
    BLACK,
    BLUE,
    GREY,
    GUIDE,
    LAND,
    RED,
    new_figure,
    new_panel,
)
from snowsim.echogram import layer_bins_of, to_db

N_BANDS = 64  # of a spectrum along track
SHOWN_PERCENT = (0.5, 99.9)  # of the powers of an echogram, from black to white
# Greenland: degrees north and east of capes and towns, clockwise from Cape Farewell.
COAST = (
    (59.8, -43.9), (65.6, -37.6), (68.1, -31.8), (70.5, -22.0), (76.8, -18.7), (81.4, -11.5),
    (83.6, -33.4), (81.2, -63.6), (78.2, -73.1), (75.9, -66.4), (74.6, -57.2), (69.3, -53.5),
    (64.2, -51.7), (61.2, -48.4), (59.8, -43.9),
)  # fmt: skip


def echogram(frame, picks, scale):
    """A frame as an image, black where nothing was measured, and the same with its picks."""
    figure, axes = new_figure(1, 2, width=8, height=4, sharey=True)
    power = frame["Data"].transpose("twtt", "slow_time").values
    power_db = to_db(np.where(power > 0, power, np.nan))
    limits = np.nanpercentile(power_db, SHOWN_PERCENT)
    layer_bins = layer_bins_of(picks, frame)
    surface_bin = np.nanmedian(layer_bins[0])
    bare, picked = axes[0]
    for ax in (bare, picked):
        ax.set_facecolor(BLACK)
        scale.plot_image(ax, power_db, surface_bin, limits)
        ax.set(xlabel="along track [km]", title="echogram")
    scale.plot_layers(picked, layer_bins, surface_bin)
    picked.set_title("with picks")
    bare.set_ylabel("depth [m]")
    return figure


def flight_line(positions, scale):
    """Frames on a map of Greenland, coloured by the thickness of slab 0."""
    figure, ax = new_panel(width=4.2, height=5.4)
    latitude, longitude = np.transpose(COAST)
    ax.fill(longitude, latitude, color=LAND)
    thickness_m = positions["first_slab_bins"] * scale.bin_m
    style = {"s": 14, "cmap": "viridis"}
    points = ax.scatter(positions["longitude"], positions["latitude"], c=thickness_m, **style)
    bar = figure.colorbar(points, ax=ax, location="bottom", shrink=0.7)
    bar.set_label("mean thickness of slab 0 [m]")
    ax.set_aspect(1 / np.cos(np.radians(positions["latitude"].mean())))
    ax.set(xlabel="longitude [°E]", ylabel="latitude [°N]")
    return figure


def positions_of(frames, frame_picks):
    """Mean position, mean thickness of slab 0 and number of picks, a row a frame."""
    rows = []
    for frame, picks in zip(frames, frame_picks, strict=True):
        layer_bins = layer_bins_of(picks, frame)
        first_slab = np.diff(layer_bins[:2], axis=0)  # empty where the surface alone is picked
        row = {
            "latitude": float(frame["Latitude"].mean()),
            "longitude": float(frame["Longitude"].mean()),
            "first_slab_bins": pd.Series(first_slab.ravel()).mean(),
            "n_picks": np.isfinite(layer_bins).sum(),
        }
        rows.append(row)
    return pd.DataFrame(rows)


def waveforms(statistics):
    """Mean waveform about the surface and the first layer; peak power of all layers."""
    figure, axes = new_figure(1, 3, width=8)
    *of_waveforms, of_peaks = axes[0]
    lag_ns = statistics["lag"] * statistics.attrs["bin_size_s"] * 1e9
    noise = float(statistics["noise_power"])
    for layer, ax in enumerate(of_waveforms):
        rows = statistics.isel(layer=layer)
        ax.plot(lag_ns, to_db(rows["mean_waveform"]), color=BLACK, label="averaged lines")
        ax.plot(lag_ns, to_db(rows["model_waveform"]), "--", color=BLUE, label="all layers")
        alone = rows["layer_waveform"] + noise
        ax.plot(lag_ns, to_db(alone), ":", color=RED, label="this layer and noise")
        ax.set(xlabel="two-way travel time [ns]", ylabel="power [dB]", title=f"about layer {layer}")
        ax.legend()
    power = statistics["peak_power"].values
    error = 2 * statistics["peak_power_standard_error"].values
    low = np.maximum(power - error, 1e-3 * power)
    layer = np.arange(power.size)
    of_peaks.vlines(layer, to_db(low), to_db(power + error), color="0.6")
    of_peaks.plot(layer, to_db(power), "o", color=BLACK)
    of_peaks.axhline(to_db(noise), **GUIDE)
    of_peaks.annotate("noise", (0, to_db(noise)), fontsize=7, va="bottom")
    of_peaks.set(xlabel="layer", ylabel="peak power [dB]", title="all layers")
    return figure


def along_track(statistics):
    """Spectra along track under the picks; tracked power beside the Gamma law."""
    figure, axes = new_figure(1, 2, width=7)
    of_spectra, of_law = axes[0]
    if "doppler_layer_1" in statistics:
        plot_spectrum(of_spectra, statistics["doppler_layer_1"], GREY, "layer 1")
        plot_spectrum(of_spectra, statistics["doppler_layer_mean"], BLACK, "mean of layers 1-15")
        of_spectra.set(xlabel="wavenumber [cycles per m]", title="Doppler spectrum")
    else:
        density = statistics["detected_power_spectrum_layer_mean"][1:]
        plot_spectrum(of_spectra, density, BLACK, "mean of layers 1-15")
        of_spectra.set_xlabel("wavenumber [cycles per range line]")
        of_spectra.set_title("spectrum of detected power")
    of_spectra.set_ylabel("density / mean [dB]")
    of_spectra.legend()
    # The paper's chi-square.
    expected = statistics["gamma_quantile"]
    of_law.plot(expected, expected, color="0.6", linewidth=1)
    of_law.plot(expected, statistics["tracked_power_quantile"], ".", color=BLACK)
    of_law.set_xlabel(f"Gamma quantile, {statistics.attrs['n_looks']:.1f} looks")
    of_law.set(ylabel="tracked power / group mean", title="quantiles of tracked power")
    return figure


def plot_spectrum(ax, density, color, label):
    """Means over bands: a single wavenumber of a single layer is exponentially distributed."""
    [along] = density.dims
    n_together = max(1, density.size // N_BANDS)
    bands = density.coarsen({along: n_together}, boundary="trim").mean()
    ax.plot(bands[along], to_db(np.maximum(bands, 1e-4)), color=color, linewidth=1, label=label)
