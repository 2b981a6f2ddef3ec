"""Candidates linked into pieces of layers: the chains that gather the most evidence."""

from dataclasses import dataclass

import numpy as np
from numba import njit

NONE = -1
NARROW = 128


@dataclass(frozen=True)
class Linking:
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
    bend: float = 1.0
    steepest: float = 2.5
    apart: float = 4.0
    evidence: float = 45.0


@dataclass(frozen=True, eq=False)
class Piece:
    """One chain: its range lines, increasing, the rows there, and log-odds above even ones."""

    line: np.ndarray
    row: np.ndarray
    excess: np.ndarray

    def at(self, line):
        """Rows at range lines, straight between those of the chain."""
        return np.interp(line, self.line, self.row)


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
    chains = _chains(
        candidates.first,
        line,
        candidates.row,
        gain,
        linking.longest,
        linking.skipped,
        linking.bend,
        linking.steepest,
        linking.apart,
        evidence,
    )
    members = np.flatnonzero(chains >= 0)
    members = members[np.argsort(chains[members], kind="stable")]
    pieces = []
    for chain in np.split(members, np.flatnonzero(np.diff(chains[members])) + 1):
        if chain.size:
            rows = candidates.row[chain].astype(float)
            pieces.append(Piece(line[chain], rows, excess[chain].astype(float)))
    return pieces


@njit(cache=True)
def _chains(first, line, row, gain, longest, skipped, bend, steepest, apart, evidence):
    """Number of the chain of every candidate, `NONE` for none; 0 is the strongest."""
    n = row.size
    chain = np.full(n, NONE, np.int32)
    free = np.ones(n, np.bool_)
    above = np.full(n, NONE, np.int32)  # the nearest chain above a candidate, and that below
    below = np.full(n, NONE, np.int32)
    above_row = np.full(n, -np.inf, np.float32)
    below_row = np.full(n, np.inf, np.float32)
    starts = [0]  # of every chain, its first and last line
    stops = [0]
    starts.pop()
    stops.pop()
    total = np.empty(n, np.float32)
    before = np.empty(n, np.int64)
    members = np.empty(first.size, np.int64)
    found = True
    while found:
        found = False
        for at in range(first.size - 1):
            _extend(
                at,
                first,
                line,
                row,
                gain,
                free,
                above,
                below,
                starts,
                stops,
                total,
                before,
                longest,
                skipped,
                bend,
                steepest,
            )
        ends = np.flatnonzero(total >= evidence)
        for end in ends[np.argsort(-total[ends], kind="mergesort")]:
            size = 0
            c = end
            fits = True
            while c != NONE and fits:
                fits = free[c]
                members[size] = c
                size += 1
                q = before[c]
                if fits and q != NONE:
                    fits = _uncrossed(q, c, line, above, below, starts, stops)
                c = q
            if not fits:
                continue
            found = True
            number = len(starts)
            starts.append(line[members[size - 1]])
            stops.append(line[end])
            chain[members[:size]] = number
            _take(
                number,
                members[:size][::-1],
                first,
                line,
                row,
                apart,
                free,
                above,
                below,
                above_row,
                below_row,
            )
    return chain


@njit(cache=True)
def _extend(
    at,
    first,
    line,
    row,
    gain,
    free,
    above,
    below,
    starts,
    stops,
    total,
    before,
    longest,
    skipped,
    bend,
    steepest,
):
    """What the best chain that ends at each candidate of a line gathers, and the one before."""
    here = slice(first[at], first[at + 1])
    total[here] = 0
    before[here] = NONE
    for gap in range(1, min(longest, at) + 1):
        reach = steepest * (0.75 + 0.25 * gap)
        nearest = first[at - gap]
        for c in range(first[at], first[at + 1]):
            if not free[c]:
                continue
            while nearest < first[at - gap + 1] and row[nearest] < row[c] - reach:
                nearest += 1
            for q in range(nearest, first[at - gap + 1]):
                step = row[c] - row[q]
                if step < -reach:
                    break
                gathered = total[q] - skipped * (gap - 1) - bend * step * step / gap
                if gathered > total[c] and _uncrossed(q, c, line, above, below, starts, stops):
                    total[c] = gathered
                    before[c] = q
    for c in range(first[at], first[at + 1]):
        total[c] = total[c] + gain[c] if free[c] else -np.inf


@njit(cache=True)
def _uncrossed(q, c, line, above, below, starts, stops):
    """Whether no chain passes between two candidates, q before c."""
    return _same(above[q], above[c], line[q], line[c], starts, stops) and _same(
        below[q], below[c], line[q], line[c], starts, stops
    )


@njit(cache=True)
def _same(left, right, left_line, right_line, starts, stops):
    """Whether two chains beside two candidates are one, or neither reaches the other's line."""
    if left == right:
        return True
    if left != NONE and stops[left] >= right_line:
        return False
    return right == NONE or starts[right] > left_line


@njit(cache=True)
def _take(number, members, first, line, row, apart, free, above, below, above_row, below_row):
    """Take candidates of a chain and those too near to it; tell others on which side it is."""
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
                free[c] = False
            if here <= row[c] and here > above_row[c]:
                above_row[c] = here
                above[c] = number
            if here >= row[c] and here < below_row[c]:
                below_row[c] = here
                below[c] = number
    free[members] = False
