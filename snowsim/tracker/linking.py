"""Peaks of every range line, linked into pieces of layers: the chains of most evidence."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

NONE = -1
NARROW = 256  # range lines of the scenes it was chosen on


# How candidates make chains; chosen on flights that no score is reported of.
MOST_LOG_ODDS = 1.0  # so much a candidate speaks at most for a layer, or against it
LONGEST_LINES = 6  # from one candidate of a chain to the next, at most
SKIPPED_LOG_ODDS = 0.5  # what a line without a candidate costs
BEND_LOG_ODDS = 0.5  # what a step of one row in one line costs; it grows with the square
STEEPEST_ROWS = 2.5  # that a chain moves in one line, at most
APART_ROWS = 4.0  # that chains keep from each other
# What a chain must gather; on fewer than `NARROW` range lines, in proportion to them.
EVIDENCE_LOG_ODDS = 55.0


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

    @staticmethod
    def concatenated(parts):
        """Candidates of stretches of range lines, one after another."""
        n_by_line = np.concatenate([np.diff(part.first) for part in parts])
        rows = np.concatenate([part.row for part in parts])
        log_odds = np.concatenate([part.log_odds for part in parts])
        return Candidates(np.r_[0, np.cumsum(n_by_line)], rows, log_odds)


@dataclass(frozen=True, eq=False)
class Piece:
    """One chain: its range lines, increasing, the rows there, and log-odds above even ones."""

    line: np.ndarray
    row: np.ndarray
    excess: np.ndarray

    def at(self, line):
        """Row at a range line, straight between those of the chain."""
        # Only what lies around it: a chain may run through a whole segment.
        first = max(0, np.searchsorted(self.line, line, "right") - 1)
        around = slice(first, np.searchsorted(self.line, line) + 1)
        return float(np.interp(line, self.line[around], self.row[around]))


def find_candidates(log_odds, threshold):
    """Peaks of a map (row, range_line) that chains may take, each at the vertex of a parabola.

    A peak of several equal rows lies in their middle. `threshold` is that of `link`.
    """
    log_odds = np.ascontiguousarray(log_odds.T, dtype=np.float32)
    return Candidates(*_peaks(log_odds, threshold - SKIPPED_LOG_ODDS))


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


def link(candidates, threshold):
    """Pieces of layers, list of `Piece`, strongest first; none cross and none share a candidate.

    A chain may begin and end anywhere. It gathers what its candidates have above the threshold,
    less what steps and skipped lines cost; the chain that gathers most is found by dynamic
    programming over range lines (a local alignment: Smith & Waterman, 1981, J. Mol. Biol. 147,
    195-197). Chains are taken from the best downwards; one that meets another is sought anew among
    what is left. `threshold` is that of the tracker, as log-odds.
    """
    line = candidates.line
    excess = candidates.log_odds - threshold
    gain = np.clip(excess, -MOST_LOG_ODDS, MOST_LOG_ODDS)
    evidence = EVIDENCE_LOG_ODDS * min(1, candidates.n_lines / NARROW)
    taken = _nothing_taken(line.size)
    _take_chains(_Peaks(candidates.first, line, candidates.row, gain), evidence, taken)
    chains = taken.chain
    members = np.flatnonzero(chains >= 0)
    members = members[np.argsort(chains[members], kind="stable")]
    pieces = []
    for chain in np.split(members, np.flatnonzero(np.diff(chains[members])) + 1):
        if chain.size:
            rows = candidates.row[chain].astype(float)
            pieces.append(Piece(line[chain], rows, excess[chain].astype(float)))
    return pieces


class _Peaks(NamedTuple):
    """Candidates, and what each gains a chain."""

    first: np.ndarray
    line: np.ndarray
    row: np.ndarray
    gain: np.ndarray


class _Taken(NamedTuple):
    """Chains taken so far, and what they are to every candidate."""

    chain: np.ndarray  # its own, `NONE` for none
    free: np.ndarray
    above: np.ndarray  # the nearest chain above it, and where that is
    above_row: np.ndarray
    below: np.ndarray
    below_row: np.ndarray
    start: np.ndarray  # of every chain, its first line and its last
    stop: np.ndarray


def _nothing_taken(n):
    chain, above, below, start, stop = np.full((5, n), NONE, np.int32)
    far = np.full(n, np.inf, np.float32)
    return _Taken(chain, np.ones(n, bool), above, -far, below, far, start, stop)


@njit(cache=True)
def _take_chains(peaks, evidence, taken):
    """Take chains until none is left that gathers so much."""
    n_chains = 0
    total = np.empty(peaks.row.size, np.float32)
    before = np.empty(peaks.row.size, np.int64)
    n_before = -1
    while n_chains > n_before:
        n_before = n_chains
        for at in range(peaks.first.size - 1):
            _extend(at, peaks, taken, total, before)
        ends = np.flatnonzero(total >= evidence)
        meets = ~taken.free
        for end in ends[np.argsort(-total[ends], kind="mergesort")]:
            members = _trace(end, peaks, taken, before, meets)
            if members.size:
                _take(n_chains, members, peaks, taken)
                n_chains += 1


@njit(cache=True)
def _extend(at, peaks, taken, total, before):
    """What the best chain that ends at each candidate of a line gathers, and the one before."""
    first, _, row, gain = peaks
    here = slice(first[at], first[at + 1])
    total[here] = 0
    before[here] = NONE
    for gap in range(1, min(LONGEST_LINES, at) + 1):
        reach = STEEPEST_ROWS * (0.75 + 0.25 * gap)
        lost = SKIPPED_LOG_ODDS * (gap - 1)
        nearest = first[at - gap]
        for c in range(first[at], first[at + 1]):
            if not taken.free[c]:
                continue
            while nearest < first[at - gap + 1] and row[nearest] < row[c] - reach:
                nearest += 1
            for q in range(nearest, first[at - gap + 1]):
                step = row[c] - row[q]
                if step < -reach:
                    break
                gathered = total[q] - lost - BEND_LOG_ODDS * step * step / gap
                if gathered > total[c] and _uncrossed(q, c, peaks, taken):
                    total[c] = gathered
                    before[c] = q
    for c in range(first[at], first[at + 1]):
        total[c] = total[c] + gain[c] if taken.free[c] else -np.inf


@njit(cache=True)
def _trace(end, peaks, taken, before, meets):
    """Candidates of the chain to an end; none if it meets another, which is noted in `meets`."""
    members = np.empty(peaks.first.size, np.int64)
    size = 0
    c = end
    while c != NONE:
        members[size] = c
        size += 1
        q = before[c]
        fits = taken.free[c] and not meets[c] and (q == NONE or _uncrossed(q, c, peaks, taken))
        if not fits:
            meets[members[:size]] = True
            return members[:0]
        c = q
    return members[:size][::-1]


@njit(cache=True)
def _uncrossed(q, c, peaks, taken):
    """Whether no chain passes between two candidates, q before c."""
    left = peaks.line[q]
    right = peaks.line[c]
    same_above = _same(taken.above[q], taken.above[c], left, right, taken)
    return same_above and _same(taken.below[q], taken.below[c], left, right, taken)


@njit(cache=True)
def _same(beside_left, beside_right, left, right, taken):
    """Whether two chains beside two candidates are one, or neither reaches the other's line."""
    if beside_left == beside_right:
        return True
    if beside_left != NONE and taken.stop[beside_left] >= right:
        return False
    return beside_right == NONE or taken.start[beside_right] > left


@njit(cache=True)
def _take(number, members, peaks, taken):
    """Take candidates of a chain and those too near to it; tell others on which side it is."""
    first, line, row, _ = peaks
    taken.start[number] = line[members[0]]
    taken.stop[number] = line[members[-1]]
    taken.chain[members] = number
    place = 0
    for at in range(line[members[0]], line[members[-1]] + 1):
        while place < members.size - 2 and line[members[place + 1]] <= at:
            place += 1
        left = members[place]
        here = row[left]
        if members.size > 1:
            right = members[place + 1]
            share = (at - line[left]) / (line[right] - line[left])
            here += share * (row[right] - row[left])
        for c in range(first[at], first[at + 1]):
            if abs(row[c] - here) < APART_ROWS:
                taken.free[c] = False
            if here <= row[c] and here > taken.above_row[c]:
                taken.above_row[c] = here
                taken.above[c] = number
            if here >= row[c] and here < taken.below_row[c]:
                taken.below_row[c] = here
                taken.below[c] = number
    taken.free[members] = False
