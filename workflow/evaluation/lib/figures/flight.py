"""The flight: an echogram and its picks, pixels, where its frames lie, and its statistics."""

import numpy as np
import pandas as pd
from matplotlib.patches import Rectangle
from numpy.lib.stride_tricks import sliding_window_view

from evaluation.lib.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    GUIDE,
    LAND,
    PINK,
    RED,
    WHITE,
    new_figure,
    new_panel,
    plot_echogram,
    plot_picks,
)
from snowsim.constants import EARTH_RADIUS_M
from snowsim.echogram import layer_bins_of, to_db, to_uint8

N_LINES = 4  # of the grid of pixels
N_LAYERS = 3
MARGIN_BINS = 6
LAYER_COLOURS = (RED, BLUE, GREEN, PINK)
OFFSET_DB = 25.0
N_BANDS = 64  # of a spectrum along track


def echogram(frame, picks):
    """A frame as an image, and the same with its picks."""
    figure, axes = new_figure(1, 2, width=8, height=4, sharey=True)
    image = image_with_gaps(power_of(frame))
    bare, picked = axes[0]
    plot_echogram(bare, image, "echogram")
    bare.set_ylabel("range bin")
    plot_echogram(picked, image, "with picks")
    plot_picks(picked, layer_bins_of(picks, frame))
    return figure


def power_of(frame):
    """Power of a frame, (range_bin, range_line)."""
    return frame["Data"].transpose("twtt", "slow_time").values


def image_with_gaps(power):
    """8-bit image of a frame, uint8 (range_bin, range_line), black where nothing was measured.

    Levelled frames have ragged ends: rows that fewer than half of the lines reach (where most hold
    nothing, of those that do) are black whole; in the others `to_uint8` finds the noise floor with
    the row's median in the gaps.
    """
    measured = np.isfinite(power) & (power > 0)
    reached = measured.sum(axis=1)
    rows = np.flatnonzero(2 * reached >= power.shape[1])
    if rows.size == 0:
        n_lines_held = measured.any(axis=0).sum()
        rows = np.flatnonzero((2 * reached >= n_lines_held) & (reached > 0))
    if rows.size == 0:
        msg = "an image needs a row that half of the range lines reach, got none"
        raise ValueError(msg)
    held = np.where(measured[rows], power[rows], np.nan)
    median = np.nanmedian(held, axis=1, keepdims=True)
    image = np.zeros(power.shape, dtype=np.uint8)
    image[rows], *_ = to_uint8(np.where(measured[rows], held, median))
    image[~measured] = 0
    return image


def flight_line(frames, frame_picks):
    """Frames on a map of Greenland, coloured by the thickness of slab 0, and the table of them."""
    table = pd.DataFrame(map(position, frames, frame_picks))
    figure, ax = new_panel(width=4.2, height=5.4)
    draw_coast(ax)
    x, y = project(table["latitude_deg"], table["longitude_deg"])
    ax.plot(x, y, color="0.3", linewidth=1, zorder=2)
    style = {"s": 26, "zorder": 3, "edgecolor": WHITE, "linewidth": 0.4, "cmap": "viridis"}
    points = ax.scatter(x, y, c=table["first_slab_bins"], **style)
    bar = figure.colorbar(points, ax=ax, location="bottom", shrink=0.7, pad=0.02)
    bar.set_label("mean thickness of slab 0 [range bins]")
    return figure, table


def position(frame, picks):
    """Position and mean thickness of slab 0 of a frame."""
    layer_bins = layer_bins_of(picks, frame)
    first_slab = np.diff(layer_bins[:2], axis=0)  # empty where the surface alone is picked
    is_known = np.isfinite(first_slab).any()
    return {
        "latitude_deg": float(frame["Latitude"].mean()),
        "longitude_deg": float(frame["Longitude"].mean()),
        "first_slab_bins": float(np.nanmean(first_slab)) if is_known else np.nan,
        "n_range_lines": frame.sizes["slow_time"],
        "picked": float(np.isfinite(layer_bins).mean()),
    }


def pixel_grid(frame, picks):
    """Four range lines as pixels and as curves, three layers in them, and the table of all."""
    layer_bins = layer_bins_of(picks, frame)
    line, layers = chosen_pixels(layer_bins)
    layer_bins = layer_bins[layers, line : line + N_LINES]
    power = power_of(frame)[:, line : line + N_LINES]
    first, last = chosen_bins(layer_bins, power.shape[0])
    power = power[first:last]
    power_db = to_db(np.where(power > 0, power, np.nan))  # blank where there is no echo
    bins, lines = np.meshgrid(np.arange(first, last), np.arange(N_LINES), indexing="ij")
    table = pd.DataFrame(
        {
            "range_bin": bins.ravel(),
            "range_line": lines.ravel() + line,
            "power_db": power_db.ravel(),
        }
    )
    for layer, tracked in zip(layers, layer_bins, strict=True):
        is_tracked = bins == np.rint(tracked)
        table[f"layer_{layer}"] = is_tracked.astype(int).ravel()
    figure, axes = new_figure(1, 2, width=6.5, height=4.6, width_ratios=[1, 1.2])
    as_pixels, as_curves = axes[0]
    plot_pixels(as_pixels, power_db, dict(zip(layers, layer_bins, strict=True)), first)
    plot_curves(as_curves, power_db, layer_bins, first)
    return figure, table


def plot_curves(ax, power_db, layer_bins, first_bin):
    """Range lines against range bin, each set off from the last, layers marked."""
    bins = np.arange(first_bin, first_bin + len(power_db))
    for i, (column, tracked_bins) in enumerate(zip(power_db.T, layer_bins.T, strict=True)):
        column = column + OFFSET_DB * i
        ax.plot(column, bins, color="0.3", linewidth=0.9)
        for tracked, colour in zip(np.rint(tracked_bins), LAYER_COLOURS, strict=False):
            if np.isfinite(tracked):
                power = column[int(tracked) - first_bin]
                ax.plot(power, tracked, "o", color=colour, markersize=4)
    ax.set(xlabel=f"power [dB], {OFFSET_DB:g} dB further per range line", ylabel="range bin")
    ax.set_ylim(bins[-1] + 0.5, first_bin - 0.5)


def chosen_pixels(layer_bins):
    """First of the four range lines in a row with most picked layers, and the uppermost three."""
    windows = sliding_window_view(np.isfinite(layer_bins), N_LINES, axis=1)
    picked = windows.all(axis=2)
    # More than three layers are no better than three: the first such lines are taken.
    n_picked = np.minimum(picked.sum(axis=0), N_LAYERS)
    line = int(np.argmax(n_picked))
    return line, np.flatnonzero(picked[:, line])[:N_LAYERS]


def chosen_bins(layer_bins, n_range_bins):
    """Range bins to show: those of the layers and some around; the uppermost without layers."""
    if layer_bins.size == 0:
        return 0, min(8 * MARGIN_BINS, n_range_bins)
    first = int(layer_bins.min()) - MARGIN_BINS
    last = int(layer_bins.max()) + 2 * MARGIN_BINS
    return max(first, 0), min(last, n_range_bins)


def plot_pixels(ax, power_db, layer_bins, first_bin):
    """Pixels (range_bin, range_line) from `first_bin` on, and those each layer is tracked in."""
    n_bins, n_lines = power_db.shape
    top = first_bin - 0.5
    bottom = top + n_bins
    image = ax.imshow(power_db, extent=(-0.5, n_lines - 0.5, bottom, top))
    ax.figure.colorbar(image, ax=ax, label="power [dB]")
    ax.set_xticks(np.arange(-0.5, n_lines), minor=True)
    ax.set_yticks(np.arange(top, bottom + 0.5), minor=True)
    ax.grid(which="minor", color="0.55", linewidth=0.4)
    ax.tick_params(which="minor", length=0)
    for (layer, bins), colour in zip(layer_bins.items(), LAYER_COLOURS, strict=False):
        style = {"fill": False, "edgecolor": colour, "linewidth": 1.8, "zorder": 3}
        for line in np.flatnonzero(np.isfinite(bins)):
            corner = (line - 0.5, np.rint(bins[line]) - 0.5)
            ax.add_patch(Rectangle(corner, 1, 1, **style))
        style = {"markersize": 6, "markerfacecolor": "none", "color": colour}
        ax.plot([], [], "s", label=f"layer {layer}", **style)
    ax.set(xlabel="range line", ylabel="range bin", xticks=range(n_lines))
    if layer_bins:
        narrow = {"handletextpad": 0.1, "columnspacing": 1}
        above = {"loc": "lower left", "bbox_to_anchor": (0, 1)}
        ax.legend(ncols=len(layer_bins), fontsize=8, **above, **narrow)


def waveforms(statistics):
    """Mean waveform about the surface and the first layer; peak power of all layers."""
    figure, axes = new_figure(1, 3, width=8)
    lag = statistics["lag"]
    noise = float(statistics["noise_power"])
    for layer, ax in enumerate(axes[0, :2]):
        rows = statistics.isel(layer=layer)
        ax.plot(lag, to_db(rows["mean_waveform"]), color=BLACK, label="averaged lines")
        ax.plot(lag, to_db(rows["model_waveform"]), "--", color=BLUE, label="all layers")
        alone = rows["layer_waveform"] + noise
        ax.plot(lag, to_db(alone), color=RED, label="this layer and noise")
        ax.set(xlabel=f"range bins below layer {layer}", ylabel="power [dB]")
        ax.legend()
    plot_peak_power(axes[0, 2], statistics)
    return figure


def plot_peak_power(ax, statistics):
    """Peak power of all layers with two standard errors, above the noise."""
    power = statistics["peak_power"].values
    error = 2 * statistics["peak_power_standard_error"].values
    low = np.maximum(power - error, 1e-3 * power)
    layer = np.arange(power.size)
    ax.vlines(layer, to_db(low), to_db(power + error), color="0.6")
    ax.plot(layer, to_db(power), "o", color=BLACK)
    noise_db = to_db(float(statistics["noise_power"]))
    ax.axhline(noise_db, **GUIDE)
    ax.set(xlabel="layer", ylabel="peak power [dB]")


def along_track(statistics):
    """Spectra along track under the picks; tracked power beside the Gamma law."""
    figure, axes = new_figure(1, 2, width=7)
    of_spectra, of_law = axes[0]
    if "doppler_layer_1" in statistics:
        plot_along_track(of_spectra, statistics, "doppler", statistics["doppler_wavenumber"])
        of_spectra.set_xlabel("wavenumber [cycles per m]")
        of_spectra.set_ylabel("Doppler spectrum / mean [dB]")
    else:
        wavenumber = statistics["wavenumber"][1:]
        plot_along_track(of_spectra, statistics, "detected_power_spectrum", wavenumber)
        of_spectra.set_xlabel("wavenumber [cycles per range line]")
        of_spectra.set_ylabel("spectrum of detected power / mean [dB]")
    of_spectra.legend(fontsize=7)
    # The paper's chi-square.
    expected = statistics["gamma_quantile"]
    of_law.plot(expected, expected, color="0.6", linewidth=1)
    of_law.plot(expected, statistics["tracked_power_quantile"], ".", color=BLACK)
    of_law.set_xlabel(f"Gamma quantile, {statistics.attrs['n_looks']:.1f} looks")
    of_law.set_ylabel("tracked power / group mean")
    return figure


def plot_along_track(ax, statistics, kind, wavenumber):
    """Spectra along track of layer 1 and of the mean of layers, in bands of wavenumber."""
    centres = band_means(wavenumber.values)
    lines = {"layer_1": ("layer 1", GREY), "layer_mean": ("mean of layers 1-15", BLACK)}
    for part, (label, colour) in lines.items():
        if f"{kind}_{part}" in statistics:
            density = statistics[f"{kind}_{part}"].values[-wavenumber.size :]
            bands_db = to_db(np.maximum(band_means(density), 1e-4))
            ax.plot(centres, bands_db, color=colour, linewidth=1, label=label)


def band_means(values):
    """Means over bands: a single wavenumber of a single layer is exponentially distributed."""
    n_together = max(1, values.size // N_BANDS)
    n_bands = values.size // n_together
    return values[: n_bands * n_together].reshape(n_bands, n_together).mean(axis=1)


# A map of Greenland: degrees north and east, rounded; clockwise from the southern tip. Between
# places it is straight.
COAST = (
    (59.8, -43.9), (60.1, -43.1), (60.5, -43.0),  # Cape Farewell, Prins Christian Sund, Lindenow
    (62.5, -42.1), (63.2, -41.4), (63.7, -40.5),  # Timmiarmiut, Skjoldungen, Kap Mosting
    (65.5, -39.0), (65.6, -37.6), (66.6, -34.3),  # Isortoq, Tasiilaq, Kap Gustav Holm
    (68.1, -31.8), (69.4, -24.1), (70.1, -22.1),  # Kangerlussuaq (east), Kap Dalton, Kap Brewster
    (70.5, -22.0), (71.5, -21.7), (72.5, -22.0),  # Ittoqqortoormiit, Liverpool Land, Traill Island
    (73.5, -20.4), (74.3, -20.2), (75.2, -17.5),  # Kap Broer Ruys, Daneborg, Shannon
    (76.8, -18.7), (77.7, -17.7), (81.4, -11.5),  # Danmarkshavn, Ile de France, Nordostrundingen
    (81.6, -16.7), (83.4, -26.0), (83.6, -33.4),  # Station Nord, Kap Bridgman, Cape Morris Jesup
    (83.4, -40.5), (82.3, -55.0), (81.2, -63.6),  # Lockwood Island, Cape Bryant, Kap Morton
    (80.6, -66.9), (79.2, -65.5), (78.6, -72.7),  # Kap Constitution, Humboldt, Cape Inglefield
    (78.2, -73.1), (76.5, -68.8), (75.9, -66.4),  # Cape Alexander, Pituffik, Cape York
    (76.2, -62.0), (74.6, -57.2), (72.8, -56.1),  # Melville Bay, Kullorsuaq, Upernavik
    (70.7, -54.6), (69.3, -53.5), (68.7, -52.9),  # Nuussuaq, Qeqertarsuaq, Aasiaat
    (66.9, -53.7), (65.4, -52.9), (64.2, -51.7),  # Sisimiut, Maniitsoq, Nuuk
    (62.0, -49.7), (61.2, -48.4), (60.1, -45.2),  # Paamiut, Arsuk, Nanortalik
)  # fmt: skip
CENTRAL_LONGITUDE_DEG = -42.0
TRUE_LATITUDE_DEG = 70.0
PARALLELS_DEG = (60, 65, 70, 75, 80)
MERIDIANS_DEG = (-70, -60, -50, -40, -30, -20)


def project(latitude_deg, longitude_deg):
    """Polar stereographic coordinates on a sphere, x and y [km].

    The pole is at 0, the scale is true at 70 degrees north.
    """
    latitude = np.radians(latitude_deg)
    longitude = np.radians(np.asarray(longitude_deg) - CENTRAL_LONGITUDE_DEG)
    scale = (1 + np.sin(np.radians(TRUE_LATITUDE_DEG))) * (EARTH_RADIUS_M / 1000)
    radius = scale * np.tan(np.pi / 4 - latitude / 2)
    return radius * np.sin(longitude), -radius * np.cos(longitude)


def draw_coast(ax):
    """Greenland with a labelled graticule on axes in km of `project`, without ticks."""
    coast = project(*np.transpose([*COAST, COAST[0]]))
    ax.fill(*coast, color=LAND, edgecolor="0.45", linewidth=0.8, zorder=0)
    line = {"color": "0.75", "linewidth": 0.5, "zorder": 1}
    text = {"fontsize": 7, "color": "0.35", "textcoords": "offset points"}
    for latitude in PARALLELS_DEG:
        ax.plot(*project(latitude, np.linspace(-75, -10, 100)), **line)
        end = project(latitude, -10)
        ax.annotate(f"{latitude}°N", end, xytext=(2, 0), va="center", **text)
    for longitude in MERIDIANS_DEG:
        ax.plot(*project(np.linspace(58.5, 83, 50), longitude), **line)
        end = project(58.5, longitude)
        ax.annotate(f"{-longitude}°W", end, xytext=(0, -2), ha="center", va="top", **text)
    ax.set_aspect("equal")
    ax.set_axis_off()
