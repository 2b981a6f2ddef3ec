"""The two-sample test: how often a small network tells patches of observed scenes from drawn ones.

Half of the decisions are right by chance. No scene decides about another of its own split.
"""

from functools import partial

import numpy as np
import pandas as pd
from numpy.lib.stride_tricks import sliding_window_view

from evaluation.lib.patch_network import fit_network
from snowsim.echogram import SURFACE_ROW

PATCH = 64  # [pixels] height and width
# The uppermost patches hold the surface, deeper ones snow alone.
FIRST_ROW = SURFACE_ROW - PATCH // 2
N_BOOTSTRAP = 500
COLUMNS = ["scenes", "classifier", "first_row", "accuracy", "low", "high", "n_scenes"]


def two_sample_table(sets, *, n_splits, n_steps, stream):
    """How often a network tells observed scenes from drawn ones, and one half from the other.

    `sets` maps names to lists of scenes, `observed` first, all of one length; `stream` gives a
    generator by keys. Rows: `scenes`, `classifier`, `first_row` of the patches (-1: all),
    `accuracy`, its 95 % interval over scenes, how many; NaN of one scene alone.
    """
    patches = tiled(sets)
    observed = patches["observed"]
    pairs = {name: (observed, of_set) for name, of_set in patches.items()}
    pairs["observed"] = (observed[::2], observed[1::2])
    rows = []
    for name, pair in pairs.items():
        n_used = min(n_splits, *map(len, pair))
        if n_used < 2:  # nothing is left to learn from while a scene is held out
            rows.append((name, "network", -1, np.nan, np.nan, np.nan, sum(map(len, pair))))
            continue
        fit = partial(fit_network, n_steps=n_steps, rng=stream(name))
        right = decisions(*pair, n_splits=n_used, fit=fit)
        n_scenes = sum(map(len, pair))
        for number in range(-1, observed.shape[1]):
            chosen = slice(None) if number < 0 else slice(number, number + 1)
            first_row = -1 if number < 0 else FIRST_ROW + PATCH * number
            shares = [side[:, chosen].mean(axis=(1, 2)) for side in right]
            found = accuracy(shares, rng=stream(name, "network", number))
            rows.append((name, "network", first_row, *found, n_scenes))
    return pd.DataFrame(rows, columns=COLUMNS)


def tiled(sets):
    """Patches of the scenes of every set, (scene, row, column, range_bin, range_line).

    At equal depths in all.
    """
    everything = [scene for scenes in sets.values() for scene in scenes]
    n_bins = min(scene.n_range_bins for scene in everything)
    n_lines = min(scene.n_range_lines for scene in everything)
    if n_bins < FIRST_ROW + PATCH or n_lines < PATCH:
        msg = (
            f"two-sample test: expected scenes of {FIRST_ROW + PATCH} x {PATCH} pixels or more, "
            f"the smallest has {n_bins} x {n_lines}"
        )
        raise ValueError(msg)
    patches = {}
    for name, scenes in sets.items():
        images = np.array([scene.image[FIRST_ROW:n_bins, :n_lines] for scene in scenes])
        windows = sliding_window_view(images, (PATCH, PATCH), axis=(1, 2))
        patches[name] = windows[:, ::PATCH, ::PATCH]
    return patches


def decisions(one, other, *, n_splits, fit):
    """Whether patches of two classes are classified rightly, two arrays (scene, row, column).

    `fit` takes patches of uint8 (patch, range_bin, range_line) with truth of bool (patch,), to give
    a function to decisions. Scenes are dealt out to splits, and come back in their order; those of
    each are decided by what saw the others alone.
    """
    right = ([], [])
    for split in range(n_splits):
        held = np.s_[split::n_splits]
        seen = [np.delete(scenes, held, axis=0) for scenes in (one, other)]
        seen = [scenes.reshape(-1, PATCH, PATCH) for scenes in seen]
        decide = fit(np.concatenate(seen), np.repeat([False, True], list(map(len, seen))))
        for is_other, scenes in enumerate((one, other)):
            for scene in scenes[held]:
                decided = decide(scene.reshape(-1, PATCH, PATCH)).reshape(scene.shape[:2])
                right[is_other].append(decided == bool(is_other))
    return [np.array(side) for side in right]


def accuracy(shares, *, rng):
    """Mean over two classes of the shares of right decisions, two lists by scene.

    With its 95 % interval of the bootstrap over scenes.
    """
    drawn = [rng.choice(part, (N_BOOTSTRAP, len(part))).mean(axis=1) for part in shares]
    low, high = np.percentile(np.mean(drawn, axis=0), [2.5, 97.5])
    return np.mean([np.mean(part) for part in shares]), low, high
