"""Contrast of the deepest picked layers, and of echoes that lie below the last pick."""

import numpy as np
from scipy.signal import find_peaks

from snowsim.statistics.summaries import FIRST_ROW, GROUP_LINES

DB = 10 / np.log(10)
STEPS_BETWEEN = 10  # samples from a layer above to a pick, where the valley is sought
END_GROUPS = 4  # averaged lines needed to measure a contrast
BELOW_BINS = 8  # [bins] below the last pick in which its own echo dominates
PEAK_DEVIATIONS = 4.0  # of speckle by which an unpicked echo rises


def end_contrasts(groups, frame_of):
    """Rise of layers over the snow above where no deeper one is picked: frame and dB of every averaged line.

    Power on the pick over the minimum between it and the layer above, in stretches of at least
    `END_GROUPS` averaged lines: the minimum is located on half of the lines and read on the others,
    so that speckle does not bias it low.
    """
    ends = []
    for frame in np.unique(frame_of):
        members = np.flatnonzero(frame_of == frame)
        present = groups.present[members]
        for layer in range(1, present.shape[1]):
            deepest = (
                present[:, layer] & present[:, layer - 1] & ~present[:, layer + 1 :].any(axis=1)
            )
            edges = np.flatnonzero(np.diff(np.concatenate([[0], deepest, [0]])))
            for start, stop in edges.reshape(-1, 2):
                if stop - start >= END_GROUPS:
                    ends += [(frame, _rise(groups, members[start:stop], layer))] * (stop - start)
    ends = [end for end in ends if np.isfinite(end[1])]
    return np.array([frame for frame, _ in ends], dtype=int), np.array([rise for _, rise in ends])


def _rise(groups, members, layer):
    """Power on a layer over the minimum between it and the one above [dB]."""
    position = groups.position[members].mean(axis=2)
    step = np.arange(1, STEPS_BETWEEN + 1) / STEPS_BETWEEN
    rows = (
        position[:, layer - 1, None]
        + step * (position[:, layer] - position[:, layer - 1])[:, None]
        - FIRST_ROW
    )
    whole = np.clip(np.floor(rows).astype(int), 0, groups.power.shape[1] - 2)
    share = rows - whole
    power = groups.power
    sampled = (1 - share) * power[members[:, None], whole] + share * power[
        members[:, None], whole + 1
    ]
    halves = [sampled[i::2].mean(axis=0) for i in (0, 1)]
    valley = np.mean([halves[1 - i][np.argmin(halves[i])] for i in (0, 1)])
    peak = np.mean([half[-1] for half in halves])
    return DB * np.log(peak / valley) if peak > 0 and valley > 0 else np.nan


def echoes_below(groups, block_of, n_looks):
    """Echoes that rise out of speckle in a block's mean profile below its last pick, (block, 3).

    Their number, their rise over the profile beside them, summed [dB], and the number of rows.
    """
    found = np.zeros((block_of.max() + 1, 3))
    position = groups.position.mean(axis=2)
    for block in range(len(found)):
        members = np.flatnonzero(block_of == block)
        often = 2 * groups.present[members].sum(axis=0) >= members.size
        if not often[1:].any():
            continue
        last = np.flatnonzero(often)[-1]
        members = members[groups.present[members, last]]
        first = np.rint(position[members, last]).astype(int) - FIRST_ROW + BELOW_BINS
        n_rows = groups.power.shape[1] - first.max()
        if n_rows < 3:
            continue
        stack = groups.power[members[:, None], first[:, None] + np.arange(n_rows)]
        stack = stack[:, np.isfinite(stack).all(axis=0)]
        if stack.shape[1] < 3:
            continue
        deviation_db = DB / np.sqrt(n_looks * GROUP_LINES * members.size)
        peaks, rise = find_peaks(
            DB * np.log(np.maximum(stack.mean(axis=0), 1e-300)),
            prominence=PEAK_DEVIATIONS * deviation_db,
        )
        found[block] = peaks.size, rise["prominences"].sum(), stack.shape[1]
    return found
