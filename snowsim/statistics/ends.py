"""Contrast of layers where picks end along track, and of echoes that lie below the last pick."""

import numpy as np
from scipy.signal import find_peaks

from snowsim.statistics.summaries import FIRST_ROW, GROUP_LINES

DB = 10 / np.log(10)
STEPS_BETWEEN = 10  # samples from a layer above to a pick, where the valley is sought
END_GROUPS = 4  # averaged lines that tell the contrast of a pick's end
MINIMUM_ENDS = 5
BELOW_BINS = 8  # [bins] below the last pick its own echo rules
PEAK_DEVIATIONS = 4.0  # of speckle that an unpicked echo rises


def end_contrasts(groups, frame_of):
    """Rise over the snow above where picks end along track: frame and dB of each end, and what it rests on.

    Power on the pick over the least between it and the layer above, on the last `END_GROUPS` averaged lines before the
    end: the least is sought on half of them and read on the others, so that it is not too low by speckle. Where hardly
    a pick ends, the weaker half of all picks at the depth where they are deepest stands in.
    """
    ends, deepest = [], []
    for frame in np.unique(frame_of):
        members = np.flatnonzero(frame_of == frame)
        present = groups.present[members]
        for layer in range(1, present.shape[1]):
            both = present[:, layer] & present[:, layer - 1]
            edges = np.flatnonzero(np.diff(np.concatenate([[0], both, [0]])))
            for start, stop in edges.reshape(-1, 2):
                if stop - start < END_GROUPS:
                    continue
                gone_before = start > 0 and present[start - 1, layer - 1] and not present[start - 1, layer]
                gone_after = stop < len(members) and present[stop, layer - 1] and not present[stop, layer]
                if gone_before:
                    ends.append((frame, _rise(groups, members[start : start + END_GROUPS], layer)))
                if gone_after:
                    ends.append((frame, _rise(groups, members[stop - END_GROUPS : stop], layer)))
                if not present[start:stop, layer + 1 :].any():
                    deepest.append((frame, _rise(groups, members[start:stop], layer)))
    ends, deepest = ([end for end in found if np.isfinite(end[1])] for found in (ends, deepest))
    source = "ends of picks"
    if len(ends) < MINIMUM_ENDS:
        ends = sorted(deepest, key=lambda end: end[1])[: (len(deepest) + 1) // 2]
        source = "weaker half of the deepest picks: hardly a pick ends along track"
    frames, rises = (
        (np.array(values) for values in zip(*ends, strict=True)) if ends else (np.zeros(0, int), np.zeros(0))
    )
    return (frames.astype(int), rises), source


def _rise(groups, members, layer):
    """Power on a layer over the least between it and the one above [dB]."""
    position = groups.position[members].mean(axis=2)
    step = np.arange(1, STEPS_BETWEEN + 1) / STEPS_BETWEEN
    rows = position[:, layer - 1, None] + step * (position[:, layer] - position[:, layer - 1])[:, None] - FIRST_ROW
    whole = np.clip(np.floor(rows).astype(int), 0, groups.power.shape[1] - 2)
    share = rows - whole
    power = groups.power
    sampled = (1 - share) * power[members[:, None], whole] + share * power[members[:, None], whole + 1]
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
            DB * np.log(np.maximum(stack.mean(axis=0), 1e-300)), prominence=PEAK_DEVIATIONS * deviation_db
        )
        found[block] = peaks.size, rise["prominences"].sum(), stack.shape[1]
    return found
