"""
Simulate a radar
================

A radar in physical units over twelve years of snow: its echogram, and the layers that a tracker
should find.
"""

import matplotlib.pyplot as plt
import numpy as np

import snowsim

radar = snowsim.Radar.preset("snow-2-8", height_m=400, n_looks=20)
snow = snowsim.Climate(accumulation_m=0.35, variability=0.2, n_years=12)
echogram, layers = snowsim.simulate(snow, radar, n_range_lines=512, rng=np.random.default_rng(1))

power_db = 10 * np.log10(echogram["Data"])
twtt_ns, lines = 1e9 * (echogram["twtt"] - echogram["Surface"][0]), np.arange(512)
figure, axes = plt.subplots(1, 2, sharey=True, layout="constrained")
axes[0].pcolormesh(lines, twtt_ns, power_db, cmap="gray", rasterized=True)
axes[1].plot(lines, 1e9 * (layers["twtt"].T - echogram["Surface"][0].item()), "k", linewidth=0.7)
axes[0].set(xlabel="range line", ylabel="two-way travel time below the surface [ns]", ylim=(70, -5))
axes[1].set(xlabel="range line", title="layers")
