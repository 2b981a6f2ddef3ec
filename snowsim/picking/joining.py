"""Pieces of layers joined through fades, and put in order, downwards."""

import heapq

import numpy as np

from snowsim.picking.linking import Piece

# A link is certain where the layers beside it foretell the other end to within so many rows, and no
# layer begins or ends nearer to it.
LONGEST_FADE = 200
NEAREST_ROWS = 2.0
ROWS_PER_LINE = 0.01
# Range lines at the end of a piece over which its row is averaged.
END_LINES = 10


def join_through_fades(pieces):
    """Pieces of which those that are one layer are one; a gap between them stays a gap.

    Where a piece ends, the nearest layer that goes on tells where it should be when another begins:
    neighbours keep their distance. Both must choose each other, and the line between them must
    cross no piece. The shortest gaps are closed first.
    """
    present = list(pieces)
    start, stop = _ends(pieces)
    successor = {}
    predecessor = {}
    for _, left, right in sorted(_possible_links(pieces)):
        bridge = _bridge(pieces[left], pieces[right])
        beside = np.flatnonzero((start <= bridge.line[1]) & (stop >= bridge.line[0]))
        others = [present[n] for n in beside if n not in (left, right)]
        free = left not in successor and right not in predecessor
        if free and not _crosses(bridge, others):
            present.append(bridge)
            start = np.append(start, bridge.line[0])
            stop = np.append(stop, bridge.line[1])
            successor[left] = right
            predecessor[right] = left
    return [_whole(pieces, n, successor) for n in range(len(pieces)) if n not in predecessor]


def _ends(pieces):
    """First and last range line of every piece, (piece,)."""
    first = np.array([piece.line[0] for piece in pieces], dtype=int)
    return first, np.array([piece.line[-1] for piece in pieces], dtype=int)


def _possible_links(pieces):
    """Links (gap, left, right) of ends that foretell each other."""
    start, stop = _ends(pieces)
    links = []
    for left in range(len(pieces)):
        gap = start - stop[left]
        misses = {}
        for right in np.flatnonzero((gap > 0) & (gap <= LONGEST_FADE)):
            miss = abs(_foretold(pieces, left, right, start, stop) - _row_at_end(pieces[right], 0))
            if miss <= NEAREST_ROWS + ROWS_PER_LINE * gap[right]:
                misses[int(right)] = miss
        if misses:
            right = min(misses, key=lambda each: gap[each] + 10 * misses[each])
            links.append((int(gap[right]), left, right))
    return links


def _foretold(pieces, left, right, start, stop):
    """Row where the left piece should be when the right one begins, by the nearest that goes on."""
    end = pieces[left].line[-1]
    begin = pieces[right].line[0]
    row = _row_at_end(pieces[left], -1)
    through = np.flatnonzero((start <= end) & (stop >= begin))
    if through.size == 0:
        return row
    distances = [abs(pieces[number].at(end) - row) for number in through]
    nearest = pieces[through[np.argmin(distances)]]
    return row + nearest.at(begin) - nearest.at(end)


def _row_at_end(piece, end):
    """Mean row of a piece over its first (0) or last (-1) lines."""
    return piece.row[:END_LINES].mean() if end == 0 else piece.row[-END_LINES:].mean()


def _bridge(left, right):
    """The straight line from the end of a piece to the beginning of another."""
    line = np.array([left.line[-1], right.line[0]])
    return Piece(line, np.array([left.row[-1], right.row[0]]), np.zeros(2))


def _crosses(bridge, others):
    """Whether one of other pieces lies across a bridge."""
    for piece in others:
        first = max(bridge.line[0], piece.line[0])
        last = min(bridge.line[-1], piece.line[-1])
        if first <= last:
            lines = np.arange(first, last + 1)
            above = piece.at(lines) < bridge.at(lines)
            if above.any() and not above.all():
                return True
    return False


def _whole(pieces, number, successor):
    """A piece with all that follow it."""
    members = [pieces[number]]
    while number in successor:
        number = successor[number]
        members.append(pieces[number])
    arrays = ("line", "row", "excess")
    return Piece(*(np.concatenate([getattr(piece, name) for piece in members]) for name in arrays))


def ordered(pieces):
    """Pieces downwards, such that of two on one line the upper comes first.

    Pieces do not cross, so what lies above what has no circles; where it leaves the order open, the
    piece with the lesser mean row comes first.
    """
    below = [set() for _ in pieces]
    n_above = np.zeros(len(pieces), dtype=int)
    start, stop = _ends(pieces)
    # Neighbours change only where a piece begins or ends.
    for line in np.unique([start, stop]):
        there = np.flatnonzero((start <= line) & (line <= stop))
        rows = [pieces[number].at(line) for number in there]
        there = there[np.argsort(rows, kind="stable")]
        for upper, lower in zip(there[:-1], there[1:], strict=True):
            if lower not in below[upper]:
                below[upper].add(lower)
                n_above[lower] += 1
    ready = [(pieces[number].row.mean(), number) for number in np.flatnonzero(n_above == 0)]
    heapq.heapify(ready)
    order = []
    while ready:
        _, number = heapq.heappop(ready)
        order.append(pieces[number])
        for lower in below[number]:
            n_above[lower] -= 1
            if n_above[lower] == 0:
                heapq.heappush(ready, (pieces[lower].row.mean(), lower))
    return order
