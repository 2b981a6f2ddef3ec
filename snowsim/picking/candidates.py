"""Where a layer may be: the peaks of every range line of a map of log-odds."""

from dataclasses import dataclass

import numpy as np
from numba import njit


@dataclass(frozen=True, eq=False)
class Candidates:
    """Peaks by range line, downwards: those of line i are ``first[i]:first[i + 1]``.

    Attributes
    ----------
    first : ndarray of int, (range_line + 1,)
    row : ndarray, (candidate,)
        Fractional row of the peak.
    log_odds : ndarray, (candidate,)
    """

    first: np.ndarray
    row: np.ndarray
    log_odds: np.ndarray

    @property
    def n_lines(self):
        """Number of range lines."""
        return self.first.size - 1

    @property
    def line(self):
        """Range line of every candidate, (candidate,)."""
        return np.repeat(np.arange(self.n_lines), np.diff(self.first))

    def where(self, kept):
        """Those of the candidates that are kept, bool (candidate,)."""
        n_kept = np.concatenate([[0], np.cumsum(kept)])
        return Candidates(n_kept[self.first], self.row[kept], self.log_odds[kept])


def find_candidates(log_odds, floor):
    """Peaks of a map (row, range_line) above a floor, each at the vertex of a parabola.

    A peak of several equal rows lies in their middle.
    """
    log_odds = np.ascontiguousarray(log_odds.T, dtype=np.float32)
    return Candidates(*_peaks(log_odds, floor))


def joined(parts):
    """Candidates of stretches of range lines, one after another."""
    n_before = np.cumsum([0, *(part.row.size for part in parts)])
    firsts = [part.first[:-1] + n for part, n in zip(parts, n_before[:-1], strict=True)]
    first = np.concatenate([*firsts, n_before[-1:]])
    rows = np.concatenate([part.row for part in parts])
    return Candidates(first, rows, np.concatenate([part.log_odds for part in parts]))


@njit(cache=True)
def _peaks(log_odds, floor):
    """Arrays of `Candidates` of a map (range_line, row)."""
    n_lines, n_rows = log_odds.shape
    first = np.zeros(n_lines + 1, np.int64)
    row = np.empty(n_lines * (n_rows // 2 + 1), np.float32)
    height = np.empty(row.size, np.float32)
    n = 0
    for line in range(n_lines):
        for r in range(1, n_rows - 1):
            here = log_odds[line, r]
            above = log_odds[line, r - 1]
            if not (here > floor and here > above):
                continue
            last = r
            while last < n_rows - 1 and log_odds[line, last + 1] == here:
                last += 1
            if last == n_rows - 1 or log_odds[line, last + 1] > here:
                continue
            row[n] = 0.5 * (r + last)
            if last == r:
                below = log_odds[line, r + 1]
                row[n] += 0.5 * (above - below) / (above - 2 * here + below)
            height[n] = here
            n += 1
        first[line + 1] = n
    return first, row[:n].copy(), height[:n].copy()
