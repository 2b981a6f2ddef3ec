"""Statistics of a real echogram: noise, fall with depth, texture and autocorrelation, as a table and a figure.

python benchmarks/accumulation_radar.py IMAGE.png [FOLDER]

The image is an IceBridge accumulation-radar (600-900 MHz) echogram of Greenland firn as grey levels, of which neither
decibels nor annotation are known. The surface is taken at the brightest bin of a smoothed line; grey levels are taken
as even steps of `CONTRAST_DB`, an assumption that scales every decibel and the looks, but no autocorrelation.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter, median_filter

from snowsim.echogram import Scene, to_db
from snowsim.frames import frame_of_scene
from snowsim.io.files import write_table
from snowsim.io.images import read_image
from snowsim.metrics.texture import autocorrelation, equivalent_number_of_looks, radial_psd
from snowsim.statistics import summarise
from snowsim.statistics.summaries import FIRST_ROW

CONTRAST_DB = 30.0  # from the smallest row mean to the brightest pixel: assumed
BIN_S, LINE_SPACING_M = 1e-9, 10.0  # images do not tell; nothing reported depends on them
AIR_ROWS = 16  # rows above the surface that still hold its rise
SNOW_ROWS = slice(10, 110)  # [range bins below the surface]
ACROSS_LAGS = (0, 1, 2, 3, 5, 10, 20, 50, 100)
DOWN_LAGS = (0, 1, 2, 3, 5, 8, 12, 20, 30)


def find_surface(image):
    """Row of the brightest smoothed pixel of every line, spikes removed, float (range_line,)."""
    smooth = gaussian_filter(image.astype(float), (1, 5))
    return median_filter(smooth.argmax(axis=0), 51, mode="nearest").astype(float)


def describe(image):
    """Curves and numbers of an echogram of grey levels; tables with columns curve, x, value."""
    surface = find_surface(image)
    scene = Scene("accumulation radar", image.shape[0], surface[None], image=image)
    echogram, layers = frame_of_scene(scene, bin_s=BIN_S, line_spacing_m=LINE_SPACING_M, contrast_db=CONTRAST_DB)
    (summary,) = summarise(echogram, layers, where=scene.name)
    power = echogram["Data"].values.astype(float)
    rows = np.arange(image.shape[0])[:, None]
    # Grey 0 and 255 hold what was clipped; they are 0.5 % each.
    air = rows < surface - AIR_ROWS
    noise = power[air].mean()
    level = np.stack([image[int(s) + SNOW_ROWS.start : int(s) + SNOW_ROWS.stop, i] for i, s in enumerate(surface)], 1)
    level = level.astype(float)
    known = np.isfinite(summary.power).any(axis=0)
    fall = np.nanmean(summary.power[:, known], axis=0)
    depth = np.flatnonzero(known) + FIRST_ROW
    parts = {
        "fall": (depth, to_db(fall / noise)),
        "autocorrelation along track": (ACROSS_LAGS, autocorrelation(level, ACROSS_LAGS, along="range_line")),
        "autocorrelation in range": (DOWN_LAGS, autocorrelation(level, DOWN_LAGS, along="range_bin")),
        "ring spectrum": radial_psd(level),
    }
    numbers = {
        "range lines": image.shape[1],
        "noise, grey level": image[air].mean(),
        "noise, standard deviation in grey levels": image[air].std(),
        "surface over noise, dB": to_db(np.nanmean(summary.tracked_power[0]) / noise),
        "looks of the noise": equivalent_number_of_looks(power[air]),
        "looks of the surface": equivalent_number_of_looks(summary.tracked_power[0]),
    }
    curves = [pd.DataFrame({"curve": name, "x": x, "value": value}) for name, (x, value) in parts.items()]
    scalars = [pd.DataFrame({"curve": [name], "x": [np.nan], "value": [value]}) for name, value in numbers.items()]
    return pd.concat([*scalars, *curves], ignore_index=True), surface


def draw(image, surface, table, source):
    """The figure of an image and its table."""
    from lib.figures.style import BLACK, BLUE, RED, new_figure, note_source, plot_picks

    figure, ((scene, fall), (lags, spectrum)) = new_figure(2, 2, width=8, height=5)
    curve = {name: rows for name, rows in table.groupby("curve")}
    scene.imshow(image, cmap="gray", vmin=0, vmax=255, aspect="auto", interpolation="nearest")
    plot_picks(scene, surface[None])
    scene.set(xlabel="range line", ylabel="range bin")
    fall.plot(curve["fall"]["x"], curve["fall"]["value"], color=BLACK, linewidth=0.8)
    fall.axhline(0, color="0.6", linewidth=0.8, linestyle=":")
    fall.set(xlabel="range bins below the surface", ylabel="power over noise [dB]")
    for direction, colour in (("along track", BLUE), ("in range", RED)):
        rows = curve[f"autocorrelation {direction}"]
        lags.plot(rows["x"], rows["value"], ".-", color=colour, markersize=3, linewidth=0.8, label=direction)
    lags.axhline(0, color="0.6", linewidth=0.8)
    lags.set(xlabel="lag [pixels]", ylabel="autocorrelation")
    lags.legend(fontsize=7)
    spectrum.loglog(curve["ring spectrum"]["x"], curve["ring spectrum"]["value"], color=BLACK, linewidth=0.8)
    spectrum.set(xlabel="wavenumber [cycles per pixel]", ylabel="PSD [grey levels² pixels²]")
    note_source(figure, source)
    return figure


def main(path, folder):
    from lib.figures.style import write_figure

    image, _ = read_image(path)
    table, surface = describe(image)
    write_table(Path(folder) / "accumulation_radar.csv", table)
    frame = Path(path).stem
    source = f"observed: IceBridge accumulation radar, 600-900 MHz, {frame}; {CONTRAST_DB:g} dB of contrast assumed"
    write_figure(Path(folder) / "accumulation_radar.png", draw(image, surface, table, source))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else "docs")
