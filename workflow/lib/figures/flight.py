"""The flight: an echogram and its picks, pixel by pixel too, where its frames lie, and the statistics that it gave."""

import numpy as np
import pandas as pd
from matplotlib.patches import Rectangle

from lib.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    LAND,
    PINK,
    RED,
    WHITE,
    new_figure,
    plot_echogram,
    plot_picks,
)
from snowsim.constants import EARTH_RADIUS_M
from snowsim.echogram import layer_bins_of, to_uint8

N_LINES, N_LAYERS, MARGIN_BINS = 4, 3, 6  # of the grid of pixels
LAYER_COLOURS = (RED, BLUE, GREEN, PINK)
OFFSET_DB = 25.0
N_BANDS = 64  # of a spectrum along track


def echogram(frame, picks):
    """A frame as an image, and the same with its picks."""
    figure, axes = new_figure(1, 2, width=8, height=4, sharey=True)
    image = image_with_gaps(frame["Data"].transpose("twtt", "slow_time").values)
    for ax, title in zip(axes[0], ("echogram", "with picks"), strict=True):
        plot_echogram(ax, image, title)
    plot_picks(axes[0, 1], layer_bins_of(picks, frame))
    axes[0, 0].set_ylabel("range bin")
    return figure


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
        rows = np.flatnonzero((2 * reached >= measured.any(axis=0).sum()) & (reached > 0))
    if rows.size == 0:
        msg = "an image needs a row that half of the range lines reach, got none"
        raise ValueError(msg)
    held = np.where(measured[rows], power[rows], np.nan)
    image = np.zeros(power.shape, dtype=np.uint8)
    image[rows] = to_uint8(
        np.where(measured[rows], held, np.nanmedian(held, axis=1, keepdims=True))
    )[0]
    image[~measured] = 0
    return image


def flight_line(frames, frame_picks):
    """Frames on a map of Greenland, coloured by the thickness of slab 0, and the table of them."""
    table = pd.DataFrame([position(*both) for both in zip(frames, frame_picks, strict=True)])
    figure, axes = new_figure(width=4.2, height=5.4)
    draw_coast(axes[0, 0])
    x, y = project(table["latitude_deg"], table["longitude_deg"])
    axes[0, 0].plot(x, y, color="0.3", linewidth=1, zorder=2)
    style = {"s": 26, "zorder": 3, "edgecolor": WHITE, "linewidth": 0.4, "cmap": "viridis"}
    points = axes[0, 0].scatter(x, y, c=table["first_slab_bins"], **style)
    label = "mean thickness of slab 0 [range bins]"
    figure.colorbar(points, ax=axes[0, 0], location="bottom", shrink=0.7, pad=0.02, label=label)
    return figure, table


def position(frame, picks):
    """Position and mean thickness of slab 0 of a frame."""
    layer_bins = layer_bins_of(picks, frame)
    first_slab = np.diff(layer_bins[:2], axis=0)  # empty where the surface alone is picked
    return {
        "latitude_deg": float(frame["Latitude"].mean()),
        "longitude_deg": float(frame["Longitude"].mean()),
        "first_slab_bins": float(np.nanmean(first_slab))
        if np.isfinite(first_slab).any()
        else np.nan,
        "n_range_lines": frame.sizes["slow_time"],
        "picked": float(np.isfinite(layer_bins).mean()),
    }


def pixel_grid(frame, picks):
    """Four range lines as pixels and as curves, with the pixels three layers are tracked in, and the table of them."""
    layer_bins = layer_bins_of(picks, frame)
    line, layers = chosen_pixels(layer_bins)
    layer_bins = layer_bins[layers, line : line + N_LINES]
    power = frame["Data"].transpose("twtt", "slow_time").values[:, line : line + N_LINES]
    first, last = chosen_bins(layer_bins, power.shape[0])
    power_db = 10 * np.log10(
        np.where(power[first:last] > 0, power[first:last], np.nan)
    )  # blank where there is no echo
    bins, lines = np.meshgrid(np.arange(first, last), np.arange(N_LINES), indexing="ij")
    table = {
        "range_bin": bins.ravel(),
        "range_line": lines.ravel() + line,
        "power_db": power_db.ravel(),
    }
    for layer, tracked in zip(layers, layer_bins, strict=True):
        table[f"layer_{layer}"] = (bins == np.rint(tracked)).astype(int).ravel()
    figure, axes = new_figure(1, 2, width=6.5, height=4.6, width_ratios=[1, 1.2])
    plot_pixels(axes[0, 0], power_db, dict(zip(layers, layer_bins, strict=True)), first)
    # The same lines against range bin, each set off from the last, layers marked.
    ax = axes[0, 1]
    for i, (column, tracked_bins) in enumerate(zip(power_db.T, layer_bins.T, strict=True)):
        offset = OFFSET_DB * i
        ax.plot(column + offset, bins[:, 0], color="0.3", linewidth=0.9)
        for tracked, colour in zip(np.rint(tracked_bins), LAYER_COLOURS, strict=False):
            if np.isfinite(tracked):
                ax.plot(
                    column[int(tracked) - first] + offset, tracked, "o", color=colour, markersize=4
                )
    ax.set(xlabel=f"power [dB], {OFFSET_DB:g} dB further per range line", ylabel="range bin")
    ax.set_ylim(last - 0.5, first - 0.5)
    return figure, pd.DataFrame(table)


def chosen_pixels(layer_bins):
    """First of the four range lines in a row with most picked layers, and the uppermost three of these layers."""
    picked = np.lib.stride_tricks.sliding_window_view(np.isfinite(layer_bins), N_LINES, axis=1).all(
        axis=2
    )
    # More than three layers are no better than three: the first such lines are taken.
    line = int(np.argmax(np.minimum(picked.sum(axis=0), N_LAYERS)))
    return line, np.flatnonzero(picked[:, line])[:N_LAYERS]


def chosen_bins(layer_bins, n_range_bins):
    """Range bins to show: those of the layers and some around; the uppermost where no layer is picked."""
    if layer_bins.size == 0:
        return 0, min(8 * MARGIN_BINS, n_range_bins)
    return max(int(layer_bins.min()) - MARGIN_BINS, 0), min(
        int(layer_bins.max()) + 2 * MARGIN_BINS, n_range_bins
    )


def plot_pixels(ax, power_db, layer_bins, first_bin):
    """Pixels (range_bin, range_line) from `first_bin` on with their edges, and those each layer is tracked in."""
    n_bins, n_lines = np.shape(power_db)
    extent = (-0.5, n_lines - 0.5, first_bin + n_bins - 0.5, first_bin - 0.5)
    image = ax.imshow(power_db, aspect="auto", interpolation="none", cmap="gray", extent=extent)
    ax.figure.colorbar(image, ax=ax, label="power [dB]")
    ax.set_xticks(np.arange(-0.5, n_lines), minor=True)
    ax.set_yticks(np.arange(first_bin - 0.5, first_bin + n_bins), minor=True)
    ax.grid(which="minor", color="0.55", linewidth=0.4)
    ax.tick_params(which="minor", length=0)
    for (layer, bins), colour in zip(layer_bins.items(), LAYER_COLOURS, strict=False):
        for line, tracked in enumerate(np.rint(bins)):
            if np.isfinite(tracked):
                corner = (line - 0.5, tracked - 0.5)
                ax.add_patch(
                    Rectangle(corner, 1, 1, fill=False, edgecolor=colour, linewidth=1.8, zorder=3)
                )
        ax.plot([], [], "s", markerfacecolor="none", color=colour, label=f"layer {layer}")
    ax.set(xlabel="range line", ylabel="range bin", xticks=range(n_lines))
    if layer_bins:
        ax.legend(
            loc="lower left",
            bbox_to_anchor=(0, 1),
            ncols=len(layer_bins),
            handletextpad=0.1,
            columnspacing=1,
        )


def waveforms(statistics):
    """Mean waveform about the surface and the first layer; peak power of all layers with two standard errors."""
    figure, axes = new_figure(1, 3, width=8)
    lag, noise = statistics["lag"], float(statistics["noise_power"])
    for layer, ax in enumerate(axes[0, :2]):
        rows = (
            statistics.sel(layer=layer)
            if "layer" in statistics.coords
            else statistics.isel(layer=layer)
        )
        ax.plot(lag, 10 * np.log10(rows["mean_waveform"]), color=BLACK, label="averaged lines")
        ax.plot(
            lag,
            10 * np.log10(rows["model_waveform"]),
            color=BLUE,
            linestyle="--",
            label="all layers",
        )
        ax.plot(
            lag,
            10 * np.log10(rows["layer_waveform"] + noise),
            color=RED,
            label="this layer and noise",
        )
        ax.set(xlabel=f"range bins below layer {layer}", ylabel="power [dB]")
        ax.legend(fontsize=6)
    ax, power = axes[0, 2], statistics["peak_power"].values
    error = 2 * statistics["peak_power_standard_error"].values
    low = np.maximum(power - error, 1e-3 * power)
    layer = np.arange(power.size)
    ax.vlines(layer, 10 * np.log10(low), 10 * np.log10(power + error), color="0.6")
    ax.plot(layer, 10 * np.log10(power), "o", color=BLACK, markersize=3)
    ax.axhline(10 * np.log10(noise), color="0.5", linestyle=":", linewidth=1)
    ax.set(xlabel="layer", ylabel="peak power [dB]")
    return figure


def along_track(statistics):
    """Spectra of complex echoes where there is a segment, else of detected power; tracked power, the Gamma law."""
    figure, axes = new_figure(1, 2, width=7)
    ax = axes[0, 0]
    if "doppler_layer_1" in statistics:
        x, kind = statistics["doppler_wavenumber"], "doppler"
        ax.set_ylabel("Doppler spectrum / mean [dB]")
    else:
        x, kind = statistics["wavenumber"][1:], "detected_power_spectrum"
        ax.set_ylabel("spectrum of detected power / mean [dB]")
    for part, label, colour in (
        ("layer_1", "layer 1", GREY),
        ("layer_mean", "mean of layers 1-15", BLACK),
    ):
        if f"{kind}_{part}" in statistics:
            density = statistics[f"{kind}_{part}"].values[-x.size :]
            # Means of power over bands: a single wavenumber of a single layer is exponentially
            # distributed.
            n_together = max(1, x.size // N_BANDS)
            kept = x.size // n_together * n_together
            bands = density[:kept].reshape(-1, n_together).mean(axis=1)
            centres = x.values[:kept].reshape(-1, n_together).mean(axis=1)
            ax.plot(
                centres,
                10 * np.log10(np.maximum(bands, 1e-4)),
                color=colour,
                linewidth=1,
                label=label,
            )
    ax.set_xlabel(
        "wavenumber [cycles per range line]"
        if x.name == "wavenumber"
        else "wavenumber [cycles per m]"
    )
    ax.legend(fontsize=7)
    # The paper's chi-square.
    ax = axes[0, 1]
    expected, observed = (
        statistics["gamma_quantile"].values,
        statistics["tracked_power_quantile"].values,
    )
    ax.plot(expected, expected, color="0.6", linewidth=1)
    ax.plot(expected, observed, ".", color=BLACK, markersize=3)
    n_looks = statistics.attrs["n_looks"]
    ax.set(xlabel=f"Gamma quantile, {n_looks:.1f} looks", ylabel="tracked power / group mean")
    return figure


# A map of Greenland: degrees north and east, rounded; clockwise from the southern tip. Between
# places it is straight.
COAST = (
    (59.8, -43.9), (60.1, -43.1), (60.5, -43.0),  # Cape Farewell, Prins Christian Sund, Lindenow Fjord
    (62.5, -42.1), (63.2, -41.4), (63.7, -40.5),  # Timmiarmiut, Skjoldungen, Kap Mosting
    (65.5, -39.0), (65.6, -37.6), (66.6, -34.3),  # Isortoq, Tasiilaq, Kap Gustav Holm
    (68.1, -31.8), (69.4, -24.1), (70.1, -22.1),  # Kangerlussuaq in the east, Kap Dalton, Kap Brewster
    (70.5, -22.0), (71.5, -21.7), (72.5, -22.0),  # Ittoqqortoormiit, Liverpool Land, Traill Island
    (73.5, -20.4), (74.3, -20.2), (75.2, -17.5),  # Kap Broer Ruys, Daneborg, Shannon
    (76.8, -18.7), (77.7, -17.7), (81.4, -11.5),  # Danmarkshavn, Ile de France, Nordostrundingen
    (81.6, -16.7), (83.4, -26.0), (83.6, -33.4),  # Station Nord, Kap Bridgman, Cape Morris Jesup
    (83.4, -40.5), (82.3, -55.0), (81.2, -63.6),  # Lockwood Island, Cape Bryant, Kap Morton
    (80.6, -66.9), (79.2, -65.5), (78.6, -72.7),  # Kap Constitution, Humboldt Glacier, Cape Inglefield
    (78.2, -73.1), (76.5, -68.8), (75.9, -66.4),  # Cape Alexander, Pituffik, Cape York
    (76.2, -62.0), (74.6, -57.2), (72.8, -56.1),  # Melville Bay, Kullorsuaq, Upernavik
    (70.7, -54.6), (69.3, -53.5), (68.7, -52.9),  # Nuussuaq, Qeqertarsuaq, Aasiaat
    (66.9, -53.7), (65.4, -52.9), (64.2, -51.7),  # Sisimiut, Maniitsoq, Nuuk
    (62.0, -49.7), (61.2, -48.4), (60.1, -45.2),  # Paamiut, Arsuk, Nanortalik
)  # fmt: skip
CENTRAL_LONGITUDE_DEG, TRUE_LATITUDE_DEG = -42.0, 70.0
PARALLELS_DEG, MERIDIANS_DEG = (60, 65, 70, 75, 80), (-70, -60, -50, -40, -30, -20)


def project(latitude_deg, longitude_deg):
    """Polar stereographic coordinates on a sphere, x and y [km]: the pole at 0, scale true at 70 degrees north."""
    latitude, longitude = (
        np.radians(latitude_deg),
        np.radians(np.asarray(longitude_deg) - CENTRAL_LONGITUDE_DEG),
    )
    scale = (1 + np.sin(np.radians(TRUE_LATITUDE_DEG))) * (EARTH_RADIUS_M / 1000)
    radius = scale * np.tan(np.pi / 4 - latitude / 2)
    return radius * np.sin(longitude), -radius * np.cos(longitude)


def draw_coast(ax):
    """Greenland with its graticule on axes in km of `project`; no ticks, the graticule is labelled."""
    ax.fill(
        *project(*np.array([*COAST, COAST[0]]).T),
        color=LAND,
        edgecolor="0.45",
        linewidth=0.8,
        zorder=0,
    )
    line = {"color": "0.75", "linewidth": 0.5, "zorder": 1}
    text = {"fontsize": 7, "color": "0.35", "textcoords": "offset points"}
    for latitude in PARALLELS_DEG:
        ax.plot(*project(latitude, np.linspace(-75, -10, 100)), **line)
        ax.annotate(f"{latitude}°N", project(latitude, -10), xytext=(2, 0), va="center", **text)
    for longitude in MERIDIANS_DEG:
        ax.plot(*project(np.linspace(58.5, 83, 50), longitude), **line)
        ax.annotate(
            f"{-longitude}°W",
            project(58.5, longitude),
            xytext=(0, -2),
            ha="center",
            va="top",
            **text,
        )
    ax.set_aspect("equal")
    ax.set_axis_off()
