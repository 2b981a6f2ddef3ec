"""
Tutorial: study simulation
==========================

For people who study what a radar shows of snow. From nothing to an echogram of a snow pit under two
radars, and to a first experiment: how many layers does a tracker find as the band gets narrower?
The page runs in a minute; each step can be changed and run again. It needs ``pip install
"path/to/snowsim[track]"``. Run it cell by cell, in Jupyter or an editor, or as a script that ends
with ``plt.show()``.

A radar over annual snow
------------------------

A radar has physical units, a climate gives the snow. `snowsim.simulate` returns an echogram and the
layers in it, as datasets of the Open Polar Radar convention.
"""

import matplotlib.pyplot as plt
import numpy as np

import snowsim


def plot_echogram(ax, echogram, deepest_ns):
    """Draw an echogram against two-way travel time below the surface."""
    below_ns = 1e9 * (echogram["twtt"] - echogram["Surface"][0])
    lines = np.arange(echogram.sizes["slow_time"])
    power_db = 10 * np.log10(echogram["Data"])
    ax.pcolormesh(lines, below_ns, power_db, cmap="gray", rasterized=True)
    ax.set(xlabel="range line", ylim=(deepest_ns, -4))


radar = snowsim.Radar.preset("snow-2-8", height_m=400, n_looks=20)
climate = snowsim.Climate(accumulation_m=0.35, variability=0.2, n_years=12)
echogram, layers = snowsim.simulate(climate, radar, n_range_lines=512, rng=1)

figure, axes = plt.subplots(1, 2, sharey=True, layout="constrained")
plot_echogram(axes[0], echogram, 70)
below_ns = 1e9 * (layers["twtt"] - echogram["Surface"][0])
axes[1].plot(below_ns.T, "k", linewidth=0.7)
axes[0].set(ylabel="two-way travel time below the surface [ns]", title="echogram")
axes[1].set(xlabel="range line", title="layers that a tracker should find")

# %%
# A density profile of your own
# -----------------------------
#
# A pit, a core or a penetrometer's profile serves as it was measured: here densities every 5 mm,
# two thin crusts of ice, and 10 cm that nobody could sample. The snow radar has a band of 6 GHz,
# the accumulation radar one of .3 GHz, whose range bins are 28 times as long. A radar adds the
# fields of what lies within its range cell (a *reflector* is such a sum), so the two see different
# layers of the same pit: both crusts are sharp under the snow radar, and blurred into one decay
# under the other. Most reflectors are too weak to be seen.

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
for ax, name in zip(axes[1:], ("snow-2-8", "accumulation"), strict=True):
    seen, reflectors = snowsim.simulate(pit, name, n_range_lines=128, rng=1)
    plot_echogram(ax, seen, 26)
    ax.set_title(f"{name}, {reflectors.sizes['layer']} reflectors")
axes[1].set_ylabel("two-way travel time below the surface [ns]")

# %%
# An experiment
# -------------
#
# The package's tracker picks layers of thin years, .1 m of water equivalent each, in simulations
# that differ in one setting, the bandwidth, with range bins of half its inverse. The snow is the
# same, so what changes is due to the band.

tracker = snowsim.Tracker.from_pretrained("universal")
thin_years = snowsim.Climate(accumulation_m=0.1, variability=0.2, n_years=25)
bandwidths_ghz = (1.5, 2, 3)
n_found = []
for bandwidth_ghz in bandwidths_ghz:
    bandwidth_hz = 1e9 * bandwidth_ghz
    narrower = snowsim.Radar.preset("snow-2-8", bandwidth_hz=bandwidth_hz, bin_s=0.5 / bandwidth_hz)
    seen, _ = snowsim.simulate(thin_years, narrower, n_range_lines=512, rng=1)
    picks = tracker.pick(seen)["twtt"]
    n_found.append(float(picks.notnull().sum("layer").mean()) - 1)  # without the surface

figure, ax = plt.subplots(figsize=(5, 3), layout="constrained")
ax.plot(bandwidths_ghz, n_found, "o-")
ax.axhline(thin_years.n_years, color="0.5", linestyle=":", label="layers in the snow")
ax.set(xlabel="bandwidth [GHz]", ylabel="layers found, mean over range lines", ylim=(0, None))
ax.legend()

# %%
# A wider band separates more of the 25 layers: 15.0, 15.9 and 16.4 are found, of one draw of the
# snow and its speckle; other seeds say how sure that is. What the simulation neglects, and how far
# it lies from a coherent solver, is said on the page :doc:`/stages/simulate`. To draw scenes like
# an annotated flight's instead, by its statistics, see the other examples.
