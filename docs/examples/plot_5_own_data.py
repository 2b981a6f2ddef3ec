"""
Own data
========

Read a flight, learn its statistics, draw similar scenes. Two simulated files stand in for yours;
any format that `snowsim.io.read_echogram` and `snowsim.io.read_layers` know works.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import snowsim
from snowsim.io import read_echogram, read_layers
from snowsim.statistics import fit

folder = Path(tempfile.mkdtemp())
snow = snowsim.Climate(accumulation_m=0.4)
for i in range(2):
    frame = snowsim.simulate(snow, "snow-2012", n_range_lines=512, rng=i)
    for kind, dataset in zip(("echogram", "layers"), frame, strict=True):
        dataset.to_netcdf(folder / f"{kind}_{i}.nc")

flight = (
    (read_echogram(folder / f"echogram_{i}.nc"), read_layers(folder / f"layers_{i}.nc"))
    for i in range(2)
)
image, mask = snowsim.scenes(10, statistics=fit(flight), rng=1)[0]
plt.imshow(image, cmap="gray", aspect="auto").axes.set(xlabel="range line", ylabel="range bin")
