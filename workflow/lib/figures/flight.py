"""The flight, its picks, and the statistics that it gave.

A map of Greenland: a schematic coast between named places, and a polar stereographic projection.
"""

import numpy as np
from matplotlib.patches import Rectangle

from lib.figures.style import COLOURS
from snowsim.constants import EARTH_RADIUS_M
from snowsim.echogram import to_uint8

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


# Degrees north and east, rounded; clockwise from the southern tip. The coast between them is drawn straight.
COAST = {
    "Cape Farewell": (59.8, -43.9),
    "Prins Christian Sund": (60.1, -43.1),
    "Lindenow Fjord": (60.5, -43.0),
    "Timmiarmiut": (62.5, -42.1),
    "Skjoldungen": (63.2, -41.4),
    "Kap Mosting": (63.7, -40.5),
    "Isortoq": (65.5, -39.0),
    "Tasiilaq": (65.6, -37.6),
    "Kap Gustav Holm": (66.6, -34.3),
    "Kangerlussuaq, east": (68.1, -31.8),
    "Kap Dalton": (69.4, -24.1),
    "Kap Brewster": (70.1, -22.1),
    "Ittoqqortoormiit": (70.5, -22.0),
    "Liverpool Land": (71.5, -21.7),
    "Traill Island": (72.5, -22.0),
    "Kap Broer Ruys": (73.5, -20.4),
    "Daneborg": (74.3, -20.2),
    "Shannon": (75.2, -17.5),
    "Danmarkshavn": (76.8, -18.7),
    "Ile de France": (77.7, -17.7),
    "Nordostrundingen": (81.4, -11.5),
    "Station Nord": (81.6, -16.7),
    "Kap Bridgman": (83.4, -26.0),
    "Cape Morris Jesup": (83.6, -33.4),
    "Lockwood Island": (83.4, -40.5),
    "Cape Bryant": (82.3, -55.0),
    "Kap Morton": (81.2, -63.6),
    "Kap Constitution": (80.6, -66.9),
    "Humboldt Glacier": (79.2, -65.5),
    "Cape Inglefield": (78.6, -72.7),
    "Cape Alexander": (78.2, -73.1),
    "Pituffik": (76.5, -68.8),
    "Cape York": (75.9, -66.4),
    "Melville Bay": (76.2, -62.0),
    "Kullorsuaq": (74.6, -57.2),
    "Upernavik": (72.8, -56.1),
    "Nuussuaq": (70.7, -54.6),
    "Qeqertarsuaq": (69.3, -53.5),
    "Aasiaat": (68.7, -52.9),
    "Sisimiut": (66.9, -53.7),
    "Maniitsoq": (65.4, -52.9),
    "Nuuk": (64.2, -51.7),
    "Paamiut": (62.0, -49.7),
    "Arsuk": (61.2, -48.4),
    "Nanortalik": (60.1, -45.2),
}
EARTH_RADIUS_KM = EARTH_RADIUS_M / 1000
CENTRAL_LONGITUDE_DEG = -42.0
TRUE_LATITUDE_DEG = 70.0
PARALLELS_DEG = (60, 65, 70, 75, 80)
MERIDIANS_DEG = (-70, -60, -50, -40, -30, -20)


def project(latitude_deg, longitude_deg):
    """Polar stereographic coordinates on a sphere, x and y [km]: the pole at 0, scale true at 70 degrees north."""
    latitude, longitude = np.radians(latitude_deg), np.radians(np.asarray(longitude_deg) - CENTRAL_LONGITUDE_DEG)
    scale = (1 + np.sin(np.radians(TRUE_LATITUDE_DEG))) * EARTH_RADIUS_KM
    radius = scale * np.tan(np.pi / 4 - latitude / 2)
    return radius * np.sin(longitude), -radius * np.cos(longitude)


def draw_coast(ax):
    """Greenland with its graticule on axes in km of `project`; no ticks, the graticule is labelled."""
    coast = np.array([*COAST.values(), next(iter(COAST.values()))])
    x, y = project(*coast.T)
    ax.fill(x, y, color="#EDF2F5", edgecolor="0.45", linewidth=0.8, zorder=0)
    fine = {"color": "0.75", "linewidth": 0.5, "zorder": 1}
    for latitude in PARALLELS_DEG:
        ax.plot(*project(latitude, np.linspace(-75, -10, 100)), **fine)
        at = project(latitude, -10)
        ax.annotate(
            f"{latitude}°N", at, fontsize=7, color="0.35", xytext=(2, 0), textcoords="offset points", va="center"
        )
    for longitude in MERIDIANS_DEG:
        ax.plot(*project(np.linspace(58.5, 83, 50), longitude), **fine)
        at = project(58.5, longitude)
        ax.annotate(f"{-longitude}°W", at, fontsize=7, color="0.35", xytext=(0, -2), textcoords="offset points",
                    ha="center", va="top")  # fmt: skip
    ax.set_aspect("equal")
    ax.set_axis_off()
