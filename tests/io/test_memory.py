"""How much memory it takes to fit a flight of the paper's length, in a child process, by frames.

Frames are a render of drifting layers by eq. (1). Each lies on disk as long as it is being read.
"""

import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from made_up import BIN_S, made_up_frame
from numpy.testing import assert_allclose

from snowsim.io import read_frame, write_dataset
from snowsim.phy import draw_speckle, mean_power
from snowsim.statistics import fit

N_LINES, N_BINS, N_LAYERS = 1024, 800, 20
NOISE_POWER = 1e-3


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="peak memory is read from /proc")
def test_a_flight_of_200_000_lines_is_fitted_within_a_gibibyte_and_a_half(tmp_path):
    command = [sys.executable, __file__, str(tmp_path), "196"]
    paths = {"PYTHONPATH": os.pathsep.join(sys.path)}
    child = subprocess.run(
        command, capture_output=True, text=True, timeout=1800, check=False, env=os.environ | paths
    )
    assert child.returncode == 0, child.stderr[-2000:]
    report = json.loads(child.stdout)
    assert report["n_lines"] == 200_704
    assert report["n_layers"] == N_LAYERS
    # 70 rows of air at 5 looks on 1024 lines: known to 0.2 %; the tolerance of the renders is 0.05
    # dB, 1.2 %.
    assert_allclose(report["noise_power"], NOISE_POWER, rtol=0.012)
    # Of the whole process, the libraries' 0.2 GiB included.
    assert report["peak_bytes"] < 1.5 * 2**30


def frames(folder, n_frames):
    """Frames of the flight as `read_frame` gives them, one render at times of their own."""
    row = SimpleNamespace(echogram=str(folder / "echogram.nc"), layers=str(folder / "layers.nc"))
    shapes = 0.9 ** np.arange(N_LAYERS), np.full(N_LAYERS, 12.0), np.full(N_LAYERS, 0.07)
    rng = np.random.default_rng(20120429)
    drift = np.cumsum(rng.normal(0, 0.05, size=N_LINES))
    layer_bins = 100.3 + (28 + drift) * np.arange(N_LAYERS)[:, None]
    power = mean_power(layer_bins, *shapes, N_BINS)
    power = draw_speckle(power + NOISE_POWER, 5, method="gamma", rng=rng).astype(np.float32)
    for index in range(n_frames):
        echogram, layers = made_up_frame(power, layer_bins, minute=index)
        write_dataset(row.echogram, echogram)
        write_dataset(row.layers, layers)
        yield read_frame(row, bin_s=BIN_S)


if __name__ == "__main__":
    statistics = fit(frames(Path(sys.argv[1]), int(sys.argv[2])))
    # Largest resident memory of this process so far; not that of the process it was forked from, as
    # getrusage has.
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
    report = {
        "n_lines": int(statistics["n_picks"][0]),
        "n_layers": statistics.sizes["layer"],
        "noise_power": float(statistics["noise_power"]),
        "peak_bytes": int(status["VmHWM"].split()[0]) * 1024,
    }
    print(json.dumps(report))  # noqa: T201
