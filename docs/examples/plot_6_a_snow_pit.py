"""
A snow pit under two radars
===========================

A profile as people measure it, here drawn: densities every 5 mm, two thin crusts of ice, 10 cm that
nobody could sample. A radar adds the fields of what lies within its range cell, so the two see
different layers of the same pit.
"""

import matplotlib.pyplot as plt
import numpy as np

import snowsim

rng = np.random.default_rng(1)
depth_m = np.arange(0.0025, 3, 0.005)
density = 330 + 25 * depth_m + 20 * np.sin(2 * np.pi * depth_m / 0.6)
density += 15 * rng.standard_normal(depth_m.size)
density[[160, 420]] = 800  # ice
density[300:320] = np.nan  # missing
sampled = np.isfinite(density)  # samples reach half-way to their neighbours
pit = snowsim.Snowpack.from_profile(depth_m[sampled], density[sampled])

figure, axes = plt.subplots(1, 3, figsize=(9, 4), layout="constrained")
axes[0].plot(density, depth_m, "k", linewidth=0.7)
axes[0].set(xlabel="density [kg m-3]", ylabel="depth [m]", ylim=(3, -0.2))
for ax, radar in zip(axes[1:], ("snow-2-8", "accumulation"), strict=True):
    echogram, layers = snowsim.simulate(pit, radar, n_range_lines=128, rng=1)
    below_ns = 1e9 * (echogram["twtt"] - echogram["Surface"][0])
    power_db = 10 * np.log10(echogram["Data"])
    ax.pcolormesh(np.arange(128), below_ns, power_db, cmap="gray", rasterized=True)
    ax.set(title=f"{radar}, {layers.sizes['layer']} reflectors", xlabel="range line", ylim=(26, -2))
axes[1].set_ylabel("two-way travel time below the surface [ns]")
