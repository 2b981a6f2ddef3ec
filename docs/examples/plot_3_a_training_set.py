"""
A training set
==============

Scenes drawn from the statistics of the synthetic reference flight, which come with the package,
each with its mask. A ``torch.utils.data.DataLoader`` accepts them directly; ``write`` saves them in
the published benchmark's layout.
"""

import matplotlib.pyplot as plt

import snowsim

scenes = snowsim.scenes(1500, rng=7, n_range_bins=400)

figure, axes = plt.subplots(2, 4, sharex=True, sharey=True, figsize=(9, 6), layout="constrained")
for number, (above, below) in enumerate(axes.T):
    image, mask = scenes[number]
    above.imshow(image, cmap="gray", aspect="auto")
    below.imshow(mask, cmap="gray_r", aspect="auto")
    above.set_title(f"scene {number}")
axes[0, 0].set_ylabel("range bin")
axes[1, 0].set(ylabel="range bin", xlabel="range line")
