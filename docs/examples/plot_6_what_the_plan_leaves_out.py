"""
What the plan leaves out
========================

PHY computes only what the tolerance requires: errors of one scene's mean power at three tolerances,
with the share of layers times pixels that was computed, and the layers that are hidden by noise.
"""

import matplotlib.pyplot as plt
import numpy as np

from snowsim.phy import mean_power, plan

n_layers, noise = 25, 1e-3
layer_bins = np.linspace(50, 480, n_layers)[:, None] + 4 * np.sin(np.arange(256) / 30)
shapes = {"variance_bins2": np.full(n_layers, 2.0), "decay_rate": np.full(n_layers, 0.1)}
layers = {"peak_power": np.geomspace(1, 1e-6, n_layers), **shapes}
exact = mean_power(layer_bins, **layers, n_range_bins=560)

figure, axes = plt.subplots(1, 3, sharey=True, layout="constrained")
for ax, tolerance_db in zip(axes, (0.01, 0.1, 1), strict=True):
    planned = plan(
        layer_bins, layers | {"noise_power": noise, "n_looks": 16}, 560, tolerance_db=tolerance_db
    )
    power = mean_power(
        layer_bins, **layers, n_range_bins=560, tolerance_db=tolerance_db, noise_power=noise
    )
    error_db = np.abs(10 * np.log10((power + noise) / (exact + noise)))
    shown = ax.imshow(np.log10(error_db + 1e-9), vmin=-6, vmax=0, aspect="auto")
    ax.set_title(
        f"{tolerance_db} dB: {planned.share:.0%},\n{planned.n_dropped} layers dropped", fontsize=9
    )
figure.colorbar(shown, ax=axes, label="log10 of the error [dB]")
