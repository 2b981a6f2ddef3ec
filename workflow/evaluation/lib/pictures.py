"""What realism is measured on: echograms in decibels, of flight and real Snow Radar; real cores.

The real ones are numbers recovered from published pictures; what that does to them is said where
each is read.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import h5py
import numpy as np

from snowsim.echogram import bin_size_s, layer_bins_of, to_db
from snowsim.reference.radar import draw_detected, quantised, range_response

AIR_MARGIN_BINS = 40  # above the flight's surface, where nothing but noise is
PRODUCT_ROW_S = 8.67e-11  # two-way, of the products of 2016 as their readers print it
# As the picture of the Greenland frames was made.
MEAN_M = 100
SAMPLED_BINS = 5
SAMPLES_PER_ROW = 3.26
BINS_PER_ROW = SAMPLED_BINS * SAMPLES_PER_ROW
GREENLAND = {"2012-05-08 058": "maris_2012.npy", "2011-03-29 049-050": "maris_2011.npy"}
# Pixels per row of the product; rows of air and columns whose air no ridge reaches. The third
# picture, of 2017, is of another band (2-18 GHz) and left out.
SEA_ICE = {
    "2016-04-19 010": ("OIB_20160419_04_010.npz", 0.535, slice(10, 300), 1020),
    "2016-04-20 090": ("OIB_20160420_02_090.npz", 0.89, slice(10, 240), 800),
}


@dataclass(frozen=True)
class Picture:
    """An echogram in decibels."""

    power_db: np.ndarray  # (row, range_line), NaN where unknown
    row_s: float  # length of a row
    surface_row: np.ndarray
    air: slice  # rows of it

    def below_surface(self, first, end):
        """Rows `first` to `end` from the surface on, which is row 0, (row, range_line).

        NaN beyond the picture.
        """
        rows = self.surface_row + np.arange(first, end)[:, None]
        nearest = np.clip(rows, 0, len(self.power_db) - 1)
        values = np.take_along_axis(self.power_db, nearest, axis=0)
        return np.where(rows == nearest, values, np.nan)

    def noise(self):
        """Mean power of the air."""
        return np.nanmean(10 ** (self.power_db[self.air] / 10))


def flight_picture(echogram, layers):
    """A frame of the flight, without the range lines that are missing."""
    power = echogram["Data"].transpose("twtt", "slow_time").values.astype(float)
    surface = layer_bins_of(layers, echogram)[0]
    received = (np.isfinite(power) & (power > 0)).all(axis=0)
    usable = received & np.isfinite(surface)
    surface_row = np.rint(surface[usable]).astype(int)
    air = slice(0, surface_row.min() - AIR_MARGIN_BINS)
    return Picture(to_db(power[:, usable]), bin_size_s(echogram), surface_row, air)


def response_picture(radar, *, rng, n_rows=256, n_lines=256):
    """Noise through the flight's range response, at the rows of the products of 2016.

    The flight's own are coarser.
    """
    finer = replace(radar, bin_size_s=PRODUCT_ROW_S, n_sub_bins=2)
    margin = range_response(finer).size
    white = np.ones((n_lines, n_rows * finer.n_sub_bins + 2 * margin), dtype=np.float32)
    detected = draw_detected(white, finer, margin, finer.n_looks, rng=rng)
    power_db = to_db(quantised(detected, finer.quantisation_db).T.astype(float))
    surface_row = np.zeros(n_lines, dtype=int)
    return Picture(power_db, PRODUCT_ROW_S, surface_row, slice(0, n_rows))


def means_100m(picture, line_spacing_m):
    """A frame as the Greenland frames were published, (row, column): 100 m means of decibels.

    Every fifth bin from the surface on was plotted and about 3.26 of them melted into a row of the
    picture. Their bins are taken to be those of the products of 2016, so that rows of both sides
    are equally long: 56 of them hold a year of .184 m w.e. (13,916 annotated frames of 2012), which
    makes 1.1 cm of air, and not the 4.33 cm of other products.
    """
    # From sample to sample, in rows of the frame.
    step = SAMPLED_BINS * PRODUCT_ROW_S / picture.row_s
    n_below = len(picture.power_db) - picture.surface_row.max()
    n_rows = int(n_below / step / SAMPLES_PER_ROW)
    n_samples = int(n_rows * SAMPLES_PER_ROW)
    sampled = np.rint(np.arange(n_samples) * step).astype(int)
    samples = picture.below_surface(0, sampled[-1] + 1)[sampled]
    n_lines = round(MEAN_M / line_spacing_m)
    n_columns = samples.shape[1] // n_lines
    in_columns = samples[:, : n_columns * n_lines].reshape(n_samples, n_columns, n_lines)
    columns = in_columns.mean(axis=2)
    first = (np.arange(n_rows) * SAMPLES_PER_ROW).astype(int)
    return np.stack([columns[i : i + 3].mean(axis=0) for i in first])


def read_greenland(folder):
    """The two Greenland frames by name, (row, column) [dB].

    Rows are 16.3 bins, from the picked surface down. Traps: the length of a bin is not stated;
    decibels were averaged; 2011 was interpolated to the time axis of 2012.
    """
    frames = Path(folder) / "greenland_2011_2012"
    return {name: np.load(frames / file) for name, file in GREENLAND.items()}


def read_sea_ice(folder):
    """The two sea-ice frames of 2-8 GHz as `Picture` by name, one column a range line.

    Traps: rows and columns were resampled to the nearest: along track some range lines stand twice
    and are dropped, rows are left as they are; picks drawn over are unknown; the surface is the
    brightest pixel of a range line.
    """
    frames = Path(folder) / "sea_ice_2016_2017"
    pictures = {}
    for name, (file, row_px, air, n_columns) in SEA_ICE.items():
        with np.load(frames / file) as held:
            grey = held["gray"].astype(float)
            power_db = held["dB_at_gray0"] + grey * float(held["dB_per_gray"])
            drawn_over = np.unpackbits(held["overlay_mask"], count=grey.size)
        power_db[drawn_over.reshape(grey.shape) == 1] = np.nan
        # A colour map may move a repeated column by one grey level.
        same = np.abs(np.diff(grey[air], axis=1)) <= 1
        repeated = np.pad(same.mean(axis=0) > 0.8, (1, 0))
        power_db = power_db[:, :n_columns][:, ~repeated[:n_columns]]
        surface_row = np.nanargmax(power_db, axis=0)
        pictures[name] = Picture(power_db, PRODUCT_ROW_S / row_px, surface_row, air)
    return pictures


def read_cores(folder):
    """Annual series of real cores by name, youngest year first.

    Accumulation, or thickness of annual layers. GreenTRACS cores (west Greenland) lie along a line
    and cover the years 2016 to 1955, NaN where a core has none.
    """
    cores = Path(folder) / "cores"
    table = np.genfromtxt(cores / "greentracs/Accumulation.txt")[:, :-1]
    series = {f"GreenTRACS {i + 1}": column for i, column in enumerate(table.T)}
    ages = np.genfromtxt(cores / "greentracs/Core15_age_scale.txt", skip_header=1)
    series["GreenTRACS 15, thickness"] = np.diff(ages[:, 0])
    series["Summit"] = np.loadtxt(cores / "summit/gisp2_accum_1939_1743_kgm2.txt").ravel()
    depth_m = np.loadtxt(cores / "summit/gisp2_depth_of_year_1989_1930.txt").ravel()
    series["Summit, thickness"] = np.diff(depth_m)
    return series


def read_densities(folder):
    """Depth [m] and density [kg m-3] of the two cores sampled every 0.1 m or so, by name."""

    def read(file):
        return np.genfromtxt(Path(folder) / "cores" / file, delimiter=",", skip_header=1)

    core15 = read("greentracs/Core15_depth_density.txt")
    summit = read("summit/summit_density_top10m.csv")
    return {"GreenTRACS 15": core15 * [1, 1e3], "Summit": summit}


def read_core_b26(folder):
    """Depth [m] and density [kg m-3] of core B26, a sample a millimetre but for gaps."""
    with np.load(Path(folder) / "core_b26/b26_density_1mm.npz") as held:
        return held["midpoint_depth_m"].astype(float), held["density_kg_m3"].astype(float)


def read_horizons(folder):
    """Two-way travel times of eleven horizons of GreenTRACS, (horizon, trace) [ns].

    Picked in a 500 MHz sled radar at the smallest offset, in steps of 0.2 ns; their spacing along
    track is not stated.
    """
    file = "6-2-16-Core7-Spur-W-TimeHorizon.mat"
    with h5py.File(Path(folder) / "horizons_greentracs" / file) as held:
        picks = held["ReflectionFBpick"]
        horizons = np.array([np.ravel(held[reference]) for reference in picks[:, 0]])
    return horizons[np.argsort(horizons.mean(axis=1))]
