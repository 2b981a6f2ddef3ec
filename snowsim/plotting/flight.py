"""The flight, its picks, and the statistics that it gave."""

import numpy as np

from snowsim.echogram import to_uint8
from snowsim.plotting.style import COLOURS


def image_with_gaps(power):
    """8-bit image of a frame, uint8 (range_bin, range_line), black where nothing was measured.

    Levelled frames have ragged ends: rows that fewer than half of the lines reach are black whole, and in the others a
    gap counts as the row's median where `to_uint8` looks for the noise floor.
    """
    measured = np.isfinite(power) & (power > 0)
    rows = np.flatnonzero(2 * measured.sum(axis=1) >= power.shape[1])
    if rows.size == 0:
        msg = "an image needs a row that half of the range lines reach, got none"
        raise ValueError(msg)
    held = np.where(measured[rows], power[rows], np.nan)
    image = np.zeros(power.shape, dtype=np.uint8)
    image[rows] = to_uint8(np.where(measured[rows], held, np.nanmedian(held, axis=1, keepdims=True)))[0]
    image[~measured] = 0
    return image


def plot_picks(ax, layer_bins):
    """Picks as thin lines over an echogram."""
    ax.plot(np.asarray(layer_bins).T, color="#E69F00", linewidth=0.5)


def plot_positions(ax, table):
    """Frames of the flight by longitude and latitude, coloured by the thickness of the first slab (Fig. 4)."""
    ax.plot(table["longitude_deg"], table["latitude_deg"], color="0.7", linewidth=1, zorder=1)
    points = ax.scatter(table["longitude_deg"], table["latitude_deg"], c=table["first_slab_bins"], s=20, zorder=2)
    ax.figure.colorbar(points, label="first slab [range bins]")
    ax.set(xlabel="longitude [deg]", ylabel="latitude [deg]")


def plot_waveform(ax, statistics, layer):
    """Mean waveform about one layer: averaged range lines, the model of all layers, the layer alone (Figs 6 and 7)."""
    rows = statistics.sel(layer=layer) if "layer" in statistics.coords else statistics.isel(layer=layer)
    lag = statistics["lag"]
    noise = float(statistics["noise_power"])
    ax.plot(lag, 10 * np.log10(rows["mean_waveform"]), color="black", label="averaged lines")
    ax.plot(lag, 10 * np.log10(rows["model_waveform"]), color=COLOURS["phy"], linestyle="--", label="all layers")
    ax.plot(lag, 10 * np.log10(rows["layer_waveform"] + noise), color=COLOURS["cgan"], label="this layer and noise")
    ax.set(xlabel=f"range bins below layer {layer}", ylabel="power [dB]")
    ax.legend(fontsize=6)


def plot_layer_powers(ax, statistics):
    """Peak power of each layer above the noise, with two standard errors."""
    power = statistics["peak_power"].values
    error = 2 * statistics["peak_power_standard_error"].values
    low = np.maximum(power - error, 1e-3 * power)
    layer = np.arange(power.size)
    ax.vlines(layer, 10 * np.log10(low), 10 * np.log10(power + error), color="0.6")
    ax.plot(layer, 10 * np.log10(power), "o", color="black", markersize=3)
    ax.axhline(10 * np.log10(float(statistics["noise_power"])), color="0.5", linestyle=":", linewidth=1)
    ax.set(xlabel="layer", ylabel="peak power [dB]")


def plot_track_spectra(ax, statistics):
    """Spectra along track under the picks: complex echoes of a segment where there is one, else detected power."""
    if "doppler_layer_1" in statistics:
        x, names = statistics["doppler_wavenumber"], ("doppler_layer_1", "doppler_layer_mean")
        ax.set_ylabel("Doppler spectrum / mean [dB]")
    else:
        x, names = (
            statistics["wavenumber"][1:],
            ("detected_power_spectrum_layer_1", "detected_power_spectrum_layer_mean"),
        )
        ax.set_ylabel("spectrum of detected power / mean [dB]")
    for name, label, colour in zip(names, ("layer 1", "mean of layers 1-15"), ("0.6", "black"), strict=True):
        if name in statistics:
            density = statistics[name].values[-x.size :]
            ax.plot(x, 10 * np.log10(np.maximum(density, 1e-4)), color=colour, linewidth=0.8, label=label)
    ax.set_xlabel("wavenumber [cycles per range line]" if x.name == "wavenumber" else "wavenumber [cycles per m]")
    ax.legend(fontsize=7)


def plot_looks(ax, statistics):
    """Quantiles of tracked power against those of Gamma(M) (the paper's chi-square)."""
    expected, observed = statistics["gamma_quantile"].values, statistics["tracked_power_quantile"].values
    ax.plot(expected, expected, color="0.6", linewidth=1)
    ax.plot(expected, observed, ".", color="black", markersize=3)
    ax.set(xlabel=f"Gamma quantile, {statistics.attrs['n_looks']:.1f} looks", ylabel="tracked power / group mean")
