"""Figures of the flight: an echogram and its picks, a map of the frames, and statistics."""

import numpy as np

from evaluation.lib.figures.style import (
    BLACK,
    GREY,
    GUIDE,
    LAND,
    name_of,
    new_figure,
    new_panel,
)
from snowsim.echogram import layer_bins_of, to_db
from snowsim.phy.waveform import waveform_exact, waveform_peak

N_BANDS = 64  # bands over which a spectrum along track is averaged
SHOWN_PERCENT = (0.5, 99.9)  # percentiles of power that are black and white
# Greenland: degrees north and east of capes and towns, clockwise from Cape Farewell.
COAST = (
    (59.8, -43.9), (65.6, -37.6), (68.1, -31.8), (70.5, -22.0), (81.4, -11.5), (83.6, -33.4),
    (81.2, -63.6), (78.2, -73.1), (74.6, -57.2), (69.3, -53.5), (64.2, -51.7), (59.8, -43.9),
)  # fmt: skip


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


def flight_line(frames):
    """Map of Greenland with the mean position of each frame."""
    figure, ax = new_panel(width=4.2, height=5)
    latitude, longitude = np.transpose(COAST)
    ax.fill(longitude, latitude, color=LAND)
    positions = [[frame[name].mean() for name in ("Latitude", "Longitude")] for frame in frames]
    latitude, longitude = np.transpose(positions)
    ax.plot(longitude, latitude, "o-", color=BLACK)
    ax.set_aspect(1 / np.cos(np.radians(latitude.mean())))
    ax.set(xlabel="longitude [°E]", ylabel="latitude [°N]", title="frames")
    return figure


def waveforms(statistics):
    """Mean waveform about the surface and the first layer; peak power of all layers."""
    figure, axes = new_figure(1, 3, width=8)
    *of_waveforms, of_peaks = axes[0]
    lag_ns = statistics["lag"] * statistics.attrs["bin_size_s"] * 1e9
    noise_db = to_db(float(statistics["noise_power"]))
    for layer, ax in enumerate(of_waveforms):
        # Of averaged lines, and of this layer alone by eq. (1).
        mean_db = to_db(statistics["mean_waveform"][layer])
        ax.plot(lag_ns, mean_db, label="mean waveform")
        ax.plot(lag_ns, to_db(layer_waveform(statistics, layer)), ":", label="layer waveform")
        ax.set(xlabel="two-way travel time [ns]", ylabel="power [dB]", title=f"about layer {layer}")
        # A layer alone falls by hundreds of decibels above its peak.
        ax.set_ylim(noise_db - 3, float(mean_db.max()) + 3)
        ax.legend()
    of_peaks.plot(to_db(statistics["peak_power"]), "o", color=BLACK)
    of_peaks.axhline(noise_db, label="noise", **GUIDE)
    of_peaks.set(xlabel="layer", ylabel="peak power [dB]", title="all layers")
    of_peaks.legend()
    return figure


def layer_waveform(statistics, layer):
    """Power of a layer alone at the lags of mean waveforms."""
    names = ("variance_bins2", "decay_rate", "offset_bins", "peak_power")
    variance, decay, offset, power = (float(statistics[name][layer]) for name in names)
    peak, height = waveform_peak(variance, decay)
    wave = waveform_exact(statistics["lag"].values - offset + peak, variance, decay)
    return power * wave / height


def along_track(statistics):
    """Spectra along track of tracked layers; quantiles of tracked power beside the Gamma law."""
    figure, axes = new_figure(1, 2, width=7)
    of_spectra, of_law = axes[0]
    is_complex = "doppler_layer_1" in statistics
    kind = "doppler" if is_complex else "detected_power_spectrum"
    of_spectra.set_xlabel(f"wavenumber [cycles per {'m' if is_complex else 'range line'}]")
    for part, colour in {"layer_1": GREY, "layer_mean": BLACK}.items():
        # Detected power with few picks has only one of both spectra, or none.
        if f"{kind}_{part}" in statistics:
            # The first wavenumber is that of the mean, which was subtracted.
            density = statistics[f"{kind}_{part}"][1:]
            plot_spectrum(of_spectra, density, colour, name_of(part))
    of_spectra.set(ylabel="density / mean [dB]", title=name_of(kind))
    of_spectra.legend()
    # The Gamma law is the paper's chi-square.
    expected = statistics["gamma_quantile"]
    of_law.plot(expected, expected, color="0.6", linewidth=1)
    of_law.plot(expected, statistics["tracked_power_quantile"], ".", color=BLACK)
    of_law.set_xlabel(f"Gamma quantile, {statistics.attrs['n_looks']:.1f} looks")
    of_law.set(ylabel="tracked power / group mean", title="quantiles of tracked power")
    return figure


def plot_spectrum(ax, density, color, label):
    """Plot a spectrum as means over bands; single wavenumbers scatter as much as their mean."""
    [along] = density.dims
    n_together = max(1, density.size // N_BANDS)
    bands = density.coarsen({along: n_together}, boundary="trim").mean()
    ax.plot(bands[along], to_db(np.maximum(bands, 1e-4)), color=color, linewidth=1, label=label)
