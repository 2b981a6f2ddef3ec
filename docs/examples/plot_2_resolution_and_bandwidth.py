"""
Resolution against bandwidth
============================

The same snow under three radars: 16 GHz resolve layers that 300 MHz blur into one echo. Almost no
noise or speckle.
"""

import matplotlib.pyplot as plt
import numpy as np

import snowsim

snow = snowsim.Snowpack(
    [0, 0.4, 0.46, 1.2, 2.0], [340, 420, 330, 430, 350], roughness_m=0.002, slope=0.005
)
figure, ax = plt.subplots(layout="constrained")
for name in ("accumulation", "snow-2-8", "snow-2-18"):
    radar = snowsim.Radar.preset(name, n_looks=1e5, surface_to_noise_db=60)
    echogram, layers = snowsim.simulate(snow, radar, n_range_lines=1, rng=np.random.default_rng(0))
    below_ns = 1e9 * (echogram["twtt"] - echogram["Surface"].item())
    cells = f"{name}: range cell {1e9 * radar.cell_s:.2f} ns"
    ax.plot(below_ns, 10 * np.log10(echogram["Data"][:, 0]), label=cells, linewidth=1)
for twtt_s in layers["twtt"][:, 0].values:
    ax.axvline(1e9 * (twtt_s - layers["twtt"][0, 0].item()), color="0.8", zorder=0)
ax.set(
    xlim=(-4, 22),
    xlabel="two-way travel time below the surface [ns]",
    ylabel="power over a flat mirror's [dB]",
)
ax.legend()
