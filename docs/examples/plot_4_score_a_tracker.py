"""
Score a tracker
===============

Edge scores of probability maps, here of a "tracker" that is only the vertical gradient of the
image.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.ndimage import gaussian_filter

import snowsim
from snowsim.metrics.edges import THRESHOLDS, match_counts, score, suppress

counts = []
for image, mask in snowsim.scenes(5, rng=3, n_range_lines=128):
    rise = np.maximum(gaussian_filter(image.astype(float), (2, 8), order=(1, 0)), 0)
    found = suppress((rise / rise.max()).astype(np.float32))
    counts.append(match_counts(found, mask > 0, THRESHOLDS))
print({name: round(float(value), 3) for name, value in score(counts).items()})

total = {name: sum(one[name] for one in counts) for name in counts[0]}
precision = total["matched_prediction"] / np.maximum(total["n_prediction"], 1)
figure, ax = plt.subplots(layout="constrained")
ax.plot(total["matched_truth"] / total["n_truth"], precision, ".-")
ax.set(xlabel="recall", ylabel="precision", xlim=(0, 1), ylim=(0, 1))
