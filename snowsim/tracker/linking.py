"""Links the peaks of range lines into pieces of layers: the chains with the most evidence."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from snowsim.compiling import compiled

NONE = -1
NARROW = 256  # range lines of the scenes on which `Linking` was chosen


class Linking(NamedTuple):
    """Rules by which candidates form chains, chosen on flights whose scores are not reported.

    Attributes
    ----------
    even_log_odds : float
        Log-odds above the tracker's threshold at which a candidate is evidence neither for nor
        against a layer.
    most_log_odds : float
        Largest evidence of one candidate, for or against a layer.
    longest_lines : int
        Largest step [range lines] from one candidate of a chain to the next.
    skipped_log_odds : float
        Cost of a range line without a candidate.
    bend_log_odds : float
        Cost of a step of one row from one line to the next; it grows with the square.
    steepest_rows : float
        Largest step [rows] of a chain from one line to the next.
    apart_rows : float
        Least distance [rows] between chains.
    evidence_log_odds : float
        Least evidence of a chain; less in proportion on fewer than `NARROW` range lines.
    """

    even_log_odds: float = 0.0
    most_log_odds: float = 1.0
    longest_lines: int = 6
    skipped_log_odds: float = 0.5
    bend_log_odds: float = 0.5
    steepest_rows: float = 2.5
    apart_rows: float = 4.0
    evidence_log_odds: float = 55.0


LINKING = Linking()


@dataclass(frozen=True, eq=False)
class Candidates:
    """Peaks by range line, downwards; those of line i are ``first[i]:first[i + 1]``.

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
        """Candidates for which `kept`, bool (candidate,), is true."""
        n_kept = np.concatenate([[0], np.cumsum(kept)])
        return Candidates(n_kept[self.first], self.row[kept], self.log_odds[kept])

    @staticmethod
    def concatenated(parts):
        """Candidates of consecutive stretches of range lines as one."""
        n_before = np.cumsum([0, *(part.row.size for part in parts)])
        firsts = [part.first[:-1] + n for part, n in zip(parts, n_before[:-1], strict=True)]
        first = np.concatenate([*firsts, n_before[-1:]])
        rows = np.concatenate([part.row for part in parts])
        return Candidates(first, rows, np.concatenate([part.log_odds for part in parts]))


@dataclass(frozen=True, eq=False)
class Piece:
    """A chain: increasing range lines, its row on each, and log-odds above even odds."""

    line: np.ndarray
    row: np.ndarray
    excess: np.ndarray

    @cached_property
    def filled(self):
        """Row on every range line from the first of the chain to its last."""
        return np.interp(np.arange(self.line[0], self.line[-1] + 1), self.line, self.row)


def find_candidates(log_odds, linking, threshold):
    """Peaks of a map (row, range_line) that chains may use, `Candidates`.

    Each lies at the vertex of the parabola through three rows; a peak of several equal rows lies in
    their middle. `threshold` is that of `link`.
    """
    floor = threshold + linking.even_log_odds - linking.skipped_log_odds
    log_odds = np.ascontiguousarray(log_odds.T, dtype=np.float32)
    return Candidates(*_peaks(log_odds, floor))


@compiled()
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


def link(candidates, linking, threshold):
    """Pieces of layers, list of `Piece`, strongest first; none cross and none share a candidate.

    A chain may begin and end anywhere. Its evidence is the sum of its candidates' log-odds above
    `even_log_odds`, less the costs of steps and of skipped lines. The chain with the most evidence
    is found by dynamic programming over range lines (a local alignment: Smith & Waterman, 1981,
    J. Mol. Biol. 147, 195-197). Chains are accepted in order of evidence; a chain that meets an
    accepted one is searched again among the remaining candidates. `threshold` is that of the
    tracker, as log-odds.
    """
    line = candidates.line
    excess = candidates.log_odds - (threshold + linking.even_log_odds)
    gain = np.clip(excess, -linking.most_log_odds, linking.most_log_odds)
    evidence = linking.evidence_log_odds * min(1, candidates.n_lines / NARROW)
    rules = linking._replace(evidence_log_odds=evidence)
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
    """Candidates, and the evidence that each adds to a chain."""

    first: np.ndarray
    line: np.ndarray
    row: np.ndarray
    gain: np.ndarray


class _Taken(NamedTuple):
    """Chains accepted so far, and their position relative to every candidate."""

    chain: np.ndarray  # number of the candidate's chain, or `NONE`
    free: np.ndarray  # whether a chain may still use the candidate
    above: np.ndarray  # nearest chain above the candidate, and its row
    above_row: np.ndarray
    below: np.ndarray
    below_row: np.ndarray
    start: np.ndarray  # first and last line of every chain
    stop: np.ndarray


def _nothing_taken(n):
    above_row = np.full(n, -np.inf, np.float32)
    numbers = [np.full(n, NONE, np.int32) for _ in range(5)]
    return _Taken(
        numbers[0], np.ones(n, bool), numbers[1], above_row, numbers[2], -above_row, *numbers[3:]
    )


@compiled()
def _take_chains(peaks, rules, taken):
    """Accept chains until none with enough evidence is left.

    After the first round, evidence is computed anew only where it may have changed: beside the
    chains that the last round accepted, and as far on as a change spreads.
    """
    n_chains = 0
    total = np.empty(peaks.row.size, np.float32)
    before = np.empty(peaks.row.size, np.int64)
    beside = np.ones(peaks.first.size - 1, np.bool_)
    n_before = -1
    while n_chains > n_before:
        n_before = n_chains
        spreads_to = -1
        for at in range(peaks.first.size - 1):
            if (beside[at] or at <= spreads_to) and _extend(at, peaks, rules, taken, total, before):
                spreads_to = at + rules.longest_lines
        beside[:] = False
        ends = np.flatnonzero(total >= rules.evidence_log_odds)
        meets = ~taken.free
        for end in ends[np.argsort(-total[ends], kind="mergesort")]:
            if meets[end] or not taken.free[end]:
                continue
            members = _trace(end, peaks, taken, before, meets)
            if members.size:
                _take(n_chains, members, peaks, rules.apart_rows, taken)
                stop = taken.stop[n_chains] + rules.longest_lines + 1
                beside[taken.start[n_chains] : stop] = True
                n_chains += 1


@compiled()
def _extend(at, peaks, rules, taken, total, before):
    """Evidence of the best chain to each candidate of line `at`, and its candidate before.

    True if either differs from what it was.
    """
    first, _, row, gain = peaks
    here = slice(first[at], first[at + 1])
    total_was = total[here].copy()
    before_was = before[here].copy()
    total[here] = 0
    before[here] = NONE
    for gap in range(1, min(rules.longest_lines, at) + 1):
        reach = rules.steepest_rows * (0.75 + 0.25 * gap)
        lost = rules.skipped_log_odds * (gap - 1)
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
                gathered = total[q] - lost - rules.bend_log_odds * step * step / gap
                if gathered > total[c] and _uncrossed(q, c, peaks, taken):
                    total[c] = gathered
                    before[c] = q
    for c in range(first[at], first[at + 1]):
        total[c] = total[c] + gain[c] if taken.free[c] else -np.inf
    return (total[here] != total_was).any() or (before[here] != before_was).any()


@compiled()
def _trace(end, peaks, taken, before, meets):
    """Candidates of the chain to `end`; none, and `meets` is set, if it meets another chain."""
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


@compiled()
def _uncrossed(q, c, peaks, taken):
    """True if no accepted chain passes between candidate q and the later candidate c."""
    left = peaks.line[q]
    right = peaks.line[c]
    if not _same(taken.above[q], taken.above[c], left, right, taken):
        return False
    return _same(taken.below[q], taken.below[c], left, right, taken)


@compiled()
def _same(beside_left, beside_right, left, right, taken):
    """True if the chains beside two candidates are the same, or end before the other's line."""
    if beside_left == beside_right:
        return True
    if beside_left != NONE and taken.stop[beside_left] >= right:
        return False
    return beside_right == NONE or taken.start[beside_right] > left


@compiled()
def _take(number, members, peaks, apart, taken):
    """Mark the candidates of a chain and those near it as used, and update its neighbours."""
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
