"""Candidates linked into pieces of layers: the chains that gather the most evidence."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

NONE = -1
NARROW = 256  # range lines of the scenes it was chosen on


class Linking(NamedTuple):
    """How candidates make chains; chosen on flights that no score is reported of.

    Attributes
    ----------
    even : float
        Log-odds, less those of the tracker's threshold, at which a candidate speaks neither for nor
        against a layer.
    most : float
        So much a candidate speaks at most for a layer, or against it.
    longest : int
        Range lines from one candidate of a chain to the next, at most.
    skipped : float
        What a line without a candidate costs.
    bend : float
        What a step of one row in one line costs; it grows with the square.
    steepest : float
        Rows that a chain moves in one line, at most.
    apart : float
        Rows that chains keep from each other.
    evidence : float
        What a chain must gather; on fewer than `NARROW` range lines, in proportion to them.
    """

    even: float = 0.0
    most: float = 1.0
    longest: int = 6
    skipped: float = 0.5
    bend: float = 0.5
    steepest: float = 2.5
    apart: float = 4.0
    evidence: float = 55.0


@dataclass(frozen=True, eq=False)
class Piece:
    """One chain: its range lines, increasing, the rows there, and log-odds above even ones."""

    line: np.ndarray
    row: np.ndarray
    excess: np.ndarray

    def at(self, line):
        """Rows at range lines, straight between those of the chain."""
        # Only what lies around them: a chain may run through a whole segment.
        first = max(0, np.searchsorted(self.line, np.min(line), "right") - 1)
        around = slice(first, np.searchsorted(self.line, np.max(line)) + 1)
        return np.interp(line, self.line[around], self.row[around])


def link(candidates, linking, threshold):
    """Pieces of layers, list of `Piece`, strongest first; none cross and none share a candidate.

    A chain may begin and end anywhere. It gathers what its candidates have above `even`, less what
    steps and skipped lines cost; the chain that gathers most is found by dynamic programming over
    range lines (a local alignment: Smith & Waterman, 1981, J. Mol. Biol. 147, 195-197). Chains are
    taken from the best downwards; one that meets another is sought anew among what is left.
    `threshold` is that of the tracker, as log-odds.
    """
    line = candidates.line
    excess = candidates.log_odds - (threshold + linking.even)
    gain = np.clip(excess, -linking.most, linking.most)
    evidence = linking.evidence * min(1, candidates.n_lines / NARROW)
    rules = linking._replace(evidence=evidence)
    taken = _nothing_taken(line.size)
    _take_chains(_Peaks(candidates.first, line, candidates.row, gain), rules, taken)
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
    above_row = np.full(n, -np.inf, np.float32)
    numbers = [np.full(n, NONE, np.int32) for _ in range(5)]
    return _Taken(
        numbers[0], np.ones(n, bool), numbers[1], above_row, numbers[2], -above_row, *numbers[3:]
    )


@njit(cache=True)
def _take_chains(peaks, rules, taken):
    """Take chains until none is left that gathers enough."""
    n_chains = 0
    total = np.empty(peaks.row.size, np.float32)
    before = np.empty(peaks.row.size, np.int64)
    n_before = -1
    while n_chains > n_before:
        n_before = n_chains
        for at in range(peaks.first.size - 1):
            _extend(at, peaks, rules, taken, total, before)
        ends = np.flatnonzero(total >= rules.evidence)
        meets = ~taken.free
        for end in ends[np.argsort(-total[ends], kind="mergesort")]:
            members = _trace(end, peaks, taken, before, meets)
            if members.size:
                _take(n_chains, members, peaks, rules.apart, taken)
                n_chains += 1


@njit(cache=True)
def _extend(at, peaks, rules, taken, total, before):
    """What the best chain that ends at each candidate of a line gathers, and the one before."""
    first, _, row, gain = peaks
    here = slice(first[at], first[at + 1])
    total[here] = 0
    before[here] = NONE
    for gap in range(1, min(rules.longest, at) + 1):
        reach = rules.steepest * (0.75 + 0.25 * gap)
        lost = rules.skipped * (gap - 1)
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
                gathered = total[q] - lost - rules.bend * step * step / gap
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
    fits = True
    while fits and c != NONE:
        q = before[c]
        fits = taken.free[c] and not meets[c]
        if fits and q != NONE:
            fits = _uncrossed(q, c, peaks, taken)
        members[size] = c
        size += 1
        c = q
    if fits:
        return members[:size][::-1]
    meets[members[:size]] = True
    return members[:0]


@njit(cache=True)
def _uncrossed(q, c, peaks, taken):
    """Whether no chain passes between two candidates, q before c."""
    left = peaks.line[q]
    right = peaks.line[c]
    if not _same(taken.above[q], taken.above[c], left, right, taken):
        return False
    return _same(taken.below[q], taken.below[c], left, right, taken)


@njit(cache=True)
def _same(beside_left, beside_right, left, right, taken):
    """Whether two chains beside two candidates are one, or neither reaches the other's line."""
    if beside_left == beside_right:
        return True
    if beside_left != NONE and taken.stop[beside_left] >= right:
        return False
    return beside_right == NONE or taken.start[beside_right] > left


@njit(cache=True)
def _take(number, members, peaks, apart, taken):
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
            if abs(row[c] - here) < apart:
                taken.free[c] = False
            if here <= row[c] and here > taken.above_row[c]:
                taken.above_row[c] = here
                taken.above[c] = number
            if here >= row[c] and here < taken.below_row[c]:
                taken.below_row[c] = here
                taken.below[c] = number
    taken.free[members] = False
