"""Contrast of the deepest picked layers, and of echoes that lie below the last pick."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import find_peaks

from snowsim.statistics.moments import DB
from snowsim.statistics.summaries import FIRST_ROW, GROUP_LINES

STEPS_BETWEEN = 10  # samples from a layer above to a pick, where the valley is sought
END_GROUPS = 4  # averaged lines needed to measure a contrast
BELOW_BINS = 8  # [bins] below the last pick in which its own echo dominates
FEWEST_ROWS = 3  # a peak has a neighbour on either side
PEAK_DEVIATIONS = 4.0  # of speckle by which an unpicked echo rises


@dataclass(frozen=True)
class EndContrasts:
    """Frame and rise [dB] of averaged lines in which a deepest layer was measured, two (line,)."""

    frame: np.ndarray
    rise_db: np.ndarray


def end_contrasts(groups, frame_of):
    """Rise of layers over the snow above where no deeper one is picked, `EndContrasts`.

    Power on the pick over the minimum between it and the layer above, in stretches of at least
    `END_GROUPS` averaged lines: the minimum is located on half of the lines and read on the others,
    so that speckle does not bias it low.
    """
    frames, rises_db = [], []
    for frame in np.unique(frame_of):
        members = np.flatnonzero(frame_of == frame)
        present = groups.present[members]
        for layer in range(1, present.shape[1]):
            deeper = present[:, layer + 1 :].any(axis=1)
            deepest = present[:, layer] & present[:, layer - 1] & ~deeper
            changes = np.diff(np.concatenate([[0], deepest, [0]]))
            for start, stop in np.flatnonzero(changes).reshape(-1, 2):
                if stop - start < END_GROUPS:
                    continue
                rise_db = _rise_db(groups, members[start:stop], layer)
                if np.isfinite(rise_db):
                    frames += [frame] * (stop - start)
                    rises_db += [rise_db] * (stop - start)
    return EndContrasts(np.array(frames, dtype=int), np.array(rises_db))


def _rise_db(groups, members, layer):
    """Power on a layer over the minimum between it and the one above [dB].

    NaN where either is not positive.
    """
    position = groups.position[members].mean(axis=2)
    slab = position[:, layer] - position[:, layer - 1]
    step = np.arange(1, STEPS_BETWEEN + 1) / STEPS_BETWEEN
    rows = position[:, layer - 1, None] + step * slab[:, None] - FIRST_ROW
    above = np.clip(np.floor(rows).astype(int), 0, groups.power.shape[1] - 2)
    share = rows - above
    lines = members[:, None]
    power = (1 - share) * groups.power[lines, above] + share * groups.power[lines, above + 1]
    even, odd = power[::2].mean(axis=0), power[1::2].mean(axis=0)
    valley = np.mean([odd[np.argmin(even)], even[np.argmin(odd)]])
    peak = np.mean([even[-1], odd[-1]])
    return DB * np.log(peak / valley) if peak > 0 and valley > 0 else np.nan


def echoes_below(groups, block_of, n_looks):
    """Echoes that rise out of speckle in a block's mean profile below its last pick, (block, 3).

    Their number, their rise over the profile beside them, summed [dB], and the number of rows.
    """
    found = np.zeros((block_of.max() + 1, 3))
    for block in range(len(found)):
        lines = _lines_below(groups, np.flatnonzero(block_of == block))
        n_lines, n_rows = lines.shape
        if n_rows < FEWEST_ROWS:
            continue
        deviation_db = DB / np.sqrt(n_looks * GROUP_LINES * n_lines)
        profile_db = DB * np.log(np.maximum(lines.mean(axis=0), 1e-300))
        peaks, rise = find_peaks(profile_db, prominence=PEAK_DEVIATIONS * deviation_db)
        found[block] = peaks.size, rise["prominences"].sum(), n_rows
    return found


def _lines_below(groups, members):
    """Averaged lines of a block below the last layer in half of them, (line, row), without gaps."""
    often = 2 * groups.present[members].sum(axis=0) >= members.size
    if not often[1:].any():
        return np.empty((0, 0))
    last = np.flatnonzero(often)[-1]
    members = members[groups.present[members, last]]
    pick = groups.position[members, last].mean(axis=1)
    first = np.rint(pick).astype(int) - FIRST_ROW + BELOW_BINS
    n_rows = max(groups.power.shape[1] - first.max(), 0)
    lines = groups.power[members[:, None], first[:, None] + np.arange(n_rows)]
    # Logarithms of single numbers differ between processors.
    return lines[:, np.isfinite(lines).all(axis=0)].astype(float)
