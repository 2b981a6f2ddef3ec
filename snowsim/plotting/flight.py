"""The flight, its picks, and the statistics that it gave."""

import numpy as np
from matplotlib.patches import Rectangle

from snowsim.echogram import to_uint8
from snowsim.plotting.greenland import draw_coast, project
from snowsim.plotting.style import COLOURS

LAYER_COLOURS = ("#D55E00", "#0072B2", "#009E73", "#CC79A7")
OFFSET_DB = 25.0
N_BANDS = 64  # of a spectrum along track


def image_with_gaps(power):
    """8-bit image of a frame, uint8 (range_bin, range_line), black where nothing was measured.

    Levelled frames have ragged ends: rows that fewer than half of the lines reach are black whole, and in the others a
    gap counts as the row's median where `to_uint8` looks for the noise floor. Where most lines hold nothing at all,
    half of those that do count instead.
    """
    measured = np.isfinite(power) & (power > 0)
    reached = measured.sum(axis=1)
    rows = np.flatnonzero(2 * reached >= power.shape[1])
    if rows.size == 0:
        rows = np.flatnonzero((2 * reached >= measured.any(axis=0).sum()) & (reached > 0))
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
    ax.plot(np.asarray(layer_bins).T, color="#E69F00", linewidth=0.6)


def plot_positions(ax, table):
    """Frames of the flight on a map of Greenland, coloured by the thickness of the first slab (Fig. 4)."""
    draw_coast(ax)
    x, y = project(table["latitude_deg"], table["longitude_deg"])
    ax.plot(x, y, color="0.3", linewidth=1, zorder=2)
    points = ax.scatter(x, y, c=table["first_slab_bins"], s=26, zorder=3, edgecolor="white",
                        linewidth=0.4, cmap="viridis")  # fmt: skip
    ax.figure.colorbar(points, ax=ax, location="bottom", shrink=0.7, pad=0.02,
                       label="mean thickness of the first slab [range bins]")  # fmt: skip


def plot_pixel_grid(ax, power_db, layer_bins, first_bin):
    """Pixels of a few range lines, their edges drawn, and the pixel each layer is tracked in (Fig. 5).

    Rows of `power_db` (range_bin, range_line) begin at range bin `first_bin`; `layer_bins` gives the bins of a layer in
    the same lines by the layer's number.
    """
    n_bins, n_lines = np.shape(power_db)
    image = ax.imshow(power_db, aspect="auto", interpolation="none", cmap="gray",
                      extent=(-0.5, n_lines - 0.5, first_bin + n_bins - 0.5, first_bin - 0.5))  # fmt: skip
    ax.figure.colorbar(image, ax=ax, label="power [dB]")
    ax.set_xticks(np.arange(-0.5, n_lines), minor=True)
    ax.set_yticks(np.arange(first_bin - 0.5, first_bin + n_bins), minor=True)
    ax.grid(which="minor", color="0.55", linewidth=0.4)
    ax.tick_params(which="minor", length=0)
    for (layer, bins), colour in zip(layer_bins.items(), LAYER_COLOURS, strict=False):
        for line, tracked in enumerate(np.rint(bins)):
            if np.isfinite(tracked):
                corner = (line - 0.5, tracked - 0.5)
                ax.add_patch(Rectangle(corner, 1, 1, fill=False, edgecolor=colour, linewidth=1.8, zorder=3))
        ax.plot([], [], "s", markerfacecolor="none", color=colour, label=f"layer {layer}")
    ax.set(xlabel="range line", ylabel="range bin", xticks=range(n_lines))
    if layer_bins:
        ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=len(layer_bins), handletextpad=0.1, columnspacing=1)


def plot_lines_power(ax, power_db, layer_bins, first_bin):
    """Power of the same few range lines against range bin, each set off from the last, layers marked (Fig. 5)."""
    n_bins, n_lines = np.shape(power_db)
    bins = np.arange(first_bin, first_bin + n_bins)
    for line in range(n_lines):
        offset = OFFSET_DB * line
        ax.plot(np.asarray(power_db)[:, line] + offset, bins, color="0.3", linewidth=0.9)
        for tracked, colour in zip(np.rint(layer_bins[:, line]), LAYER_COLOURS, strict=False):
            if np.isfinite(tracked):
                ax.plot(power_db[int(tracked) - first_bin, line] + offset, tracked, "o", color=colour, markersize=4)
    ax.set(xlabel=f"power [dB], {OFFSET_DB:g} dB further per range line", ylabel="range bin",
           ylim=(bins[-1] + 0.5, bins[0] - 0.5))  # fmt: skip


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
            # Means of power over bands: a single wavenumber of a single layer is exponentially distributed.
            n_together = max(1, x.size // N_BANDS)
            kept = x.size // n_together * n_together
            bands = density[:kept].reshape(-1, n_together).mean(axis=1)
            centres = x.values[:kept].reshape(-1, n_together).mean(axis=1)
            ax.plot(centres, 10 * np.log10(np.maximum(bands, 1e-4)), color=colour, linewidth=1, label=label)
    ax.set_xlabel("wavenumber [cycles per range line]" if x.name == "wavenumber" else "wavenumber [cycles per m]")
    ax.legend(fontsize=7)


def plot_looks(ax, statistics):
    """Quantiles of tracked power against those of Gamma(M) (the paper's chi-square)."""
    expected, observed = statistics["gamma_quantile"].values, statistics["tracked_power_quantile"].values
    ax.plot(expected, expected, color="0.6", linewidth=1)
    ax.plot(expected, observed, ".", color="black", markersize=3)
    ax.set(xlabel=f"Gamma quantile, {statistics.attrs['n_looks']:.1f} looks", ylabel="tracked power / group mean")
