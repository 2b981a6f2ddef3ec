"""Child process of `test_memory`: write, read and fit a long flight frame by frame; report what it took as JSON.

Frames are renders of drifting layers by eq. (1). Each lies on disk as long as it is being read.
"""

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import xarray as xr

from snowsim.io.files import write_dataset
from snowsim.io.frame_table import read_frame
from snowsim.phy import draw_speckle, mean_power
from snowsim.statistics import fit

N_LINES, N_BINS, N_LAYERS = 1024, 800, 20
BIN_S = 2.886e-10
NOISE_POWER = 1e-3


def draw_frame(index, rng):
    """Echogram and layers of one frame, a line every 10 ms."""
    lines = np.arange(N_LINES)
    slab = (28 + rng.normal()) * rng.uniform(0.8, 1.2, size=(N_LAYERS - 1, 1))
    slab = slab + np.cumsum(rng.normal(0, 0.05, size=(N_LAYERS - 1, N_LINES)), axis=1)
    layer_bins = 100.3 + np.cumsum(np.vstack([np.zeros(N_LINES), slab]), axis=0)
    layer = np.arange(N_LAYERS)
    power = mean_power(
        layer_bins, 0.9**layer, np.full(N_LAYERS, 12.0), np.full(N_LAYERS, 0.07), N_BINS,
        tolerance_db=0.05, noise_power=NOISE_POWER, normalise="peak", align="peak",
    )  # fmt: skip
    power = draw_speckle(power + NOISE_POWER, 5, method="gamma", rng=rng).astype(np.float32)
    slow_time = np.datetime64("2012-04-29", "ns") + (index * N_LINES + lines) * np.timedelta64(10, "ms")
    twtt = 3e-6 + BIN_S * layer_bins
    along = {
        "Latitude": 75 + 4.92e-5 * lines,
        "Longitude": np.full(N_LINES, -45.0),
        "Elevation": np.full(N_LINES, 3000.0),
        "Surface": twtt[0],
    }
    coords = {"twtt": ("twtt", 3e-6 + BIN_S * np.arange(N_BINS), {"units": "s"}), "slow_time": slow_time}
    echogram = xr.Dataset(
        {"Data": (("twtt", "slow_time"), power)} | {name: ("slow_time", values) for name, values in along.items()},
        coords=coords,
    )
    dims = ("layer", "slow_time")
    ones = np.ones(twtt.shape, dtype=np.int8)
    layers = xr.Dataset(
        {"twtt": (dims, twtt, {"units": "s"}), "quality": (dims, ones), "type": (dims, ones)},
        coords={"slow_time": slow_time},
    )
    return echogram, layers


def frames(folder, n_frames):
    """Frames of the flight as `read_frame` gives them, each from files of its own."""
    row = SimpleNamespace(echogram=str(folder / "echogram.nc"), layers=str(folder / "layers.nc"))
    for index in range(n_frames):
        echogram, layers = draw_frame(index, np.random.default_rng([20120429, index]))
        write_dataset(row.echogram, echogram)
        write_dataset(row.layers, layers)
        yield read_frame(row, bin_s=BIN_S)


def peak_bytes():
    """Largest resident memory of this process so far; not that of the process it was forked from, as getrusage has."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM:"))


def main(folder, n_frames):
    statistics = fit(frames(Path(folder), n_frames))
    report = {
        "n_lines": int(statistics["n_picks"][0]),
        "n_layers": statistics.sizes["layer"],
        "noise_power": float(statistics["noise_power"]),
        "peak_bytes": peak_bytes(),
    }
    print(json.dumps(report))  # noqa: T201


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
