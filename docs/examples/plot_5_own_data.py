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
from snowsim.reference import checked_settings, draw_climate, draw_frame
from snowsim.seeding import random_stream
from snowsim.statistics import fit

folder, settings = Path(tempfile.mkdtemp()), checked_settings({})
climate = draw_climate(settings, rng=random_stream(1, "climate"))
for i in range(2):
    frame = draw_frame(i, 2, 512, climate=climate, settings=settings, rng=random_stream(1, i))
    for kind, dataset in zip(("echogram", "layers"), frame, strict=True):
        dataset.to_netcdf(folder / f"{kind}_{i}.nc")

flight = (
    (read_echogram(folder / f"echogram_{i}.nc"), read_layers(folder / f"layers_{i}.nc"))
    for i in range(2)
)
image, mask = snowsim.scenes(10, statistics=fit(flight), rng=1)[0]
plt.imshow(image, cmap="gray", aspect="auto").axes.set(xlabel="range line", ylabel="range bin")
