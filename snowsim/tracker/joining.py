"""Pieces put in order, downwards, and those that are one layer joined."""

import numpy as np

from snowsim.tracker.linking import Piece

# Two pieces are one layer where the layers beside them foretell the row at which the second begins
# to within so many rows, and more after a gap of so many range lines.
NEAREST_ROWS = 2.0
ROWS_PER_LINE = 0.01
MOST_ROWS = 4.0
# Range lines between two pieces, at most, round by round: joined layers foretell others.
LONGEST_GAPS = (200, 800, 3200)
# Range lines at the end of a piece over which its row is averaged.
END_LINES = 10


def join(pieces):
    """Layers downwards, list of `Piece`: of two on one range line the upper comes first.

    Where a piece ends, the layers above and below it that go on tell where it should be when
    another begins: neighbours keep their distance. Both ends must choose each other, and no chain
    of layers may lie between them. The shortest gaps are closed first; a gap stays a gap.
    """
    layer = np.arange(len(pieces))
    below = _next_below(pieces)
    for longest in LONGEST_GAPS:
        for _, left, right in sorted(_links(pieces, layer, longest)):
            upper, lower = layer[left], layer[right]
            if _leads(upper, lower, below, layer) or _leads(lower, upper, below, layer):
                continue
            layer[layer == lower] = upper
            below[upper] |= below[lower]
    whole = {number: _whole(pieces, layer == number) for number in np.unique(layer)}
    return [whole[number] for number in _order(whole, layer, below)]


def downwards(pieces):
    """The pieces, list of `Piece`: of two on one range line the upper comes first."""
    order = _order(dict(enumerate(pieces)), range(len(pieces)), _next_below(pieces))
    return [pieces[number] for number in order]


def _ends(pieces):
    """First and last range line of every piece, (2, piece)."""
    ends = [piece.line[[0, -1]] for piece in pieces]
    return np.array(ends, dtype=int).reshape(-1, 2).T


def _rows_at(line, pieces, ends):
    """Rows of the pieces on a range line, by their number, downwards."""
    start, stop = ends
    there = np.flatnonzero((start <= line) & (line <= stop))
    rows = {n: pieces[n].at(line) for n in there}
    return {n: rows[n] for n in sorted(rows, key=rows.get)}


def _next_below(pieces):
    """Pieces next below each, on any range line, list of sets."""
    below = [set() for _ in pieces]
    ends = _ends(pieces)
    # Neighbours change only where a piece begins or ends.
    for line in np.unique(ends):
        there = list(_rows_at(line, pieces, ends))
        for upper, lower in zip(there[:-1], there[1:], strict=True):
            below[upper].add(lower)
    return below


def _links(pieces, layer, longest):
    """Links (gap, left, right) of pieces, ends of their layers, that choose each other."""
    start, stop = ends = _ends(pieces)
    # From left to right, so that the last of a layer stays, and the first of it reversed.
    last = {layer[n]: n for n in np.argsort(start)}.values()
    first = np.array(list({layer[n]: n for n in np.argsort(-start)}.values()), dtype=int)
    at_begin = {n: _by_layer(_rows_at(start[n], pieces, ends), layer) for n in first}
    costs = []
    for left in last:
        at_end = _by_layer(_rows_at(stop[left], pieces, ends), layer)
        gap = start[first] - stop[left]
        for right in first[(gap > 0) & (gap <= longest)]:
            gap = int(start[right] - stop[left])
            miss = _miss(pieces[left], pieces[right], at_end, at_begin[right])
            if miss <= min(NEAREST_ROWS + ROWS_PER_LINE * gap, MOST_ROWS):
                costs.append((gap + 10 * miss, gap, left, right))
    costs.sort()
    chosen = {left: cost for *cost, left, _ in costs[::-1]}
    choosing = {right: cost for *cost, _, right in costs[::-1]}
    return [
        (gap, left, right)
        for cost, gap, left, right in costs
        if chosen[left] == choosing[right] == [cost, gap]
    ]


def _by_layer(rows, layer):
    return {layer[n]: row for n, row in rows.items()}


def _miss(left, right, at_end, at_begin):
    """Rows by which a piece begins off where another, that ends before it, should be by then.

    Rows of layers where the one ends and the other begins tell, those next above and below.
    """
    row = left.row[-END_LINES:].mean()
    through = [n for n in at_end if n in at_begin]
    above = [n for n in through if at_end[n] < row][-1:]
    beneath = [n for n in through if at_end[n] >= row][:1]
    moved = [at_begin[n] - at_end[n] for n in above + beneath]
    if moved:
        row += np.interp(row, [at_end[n] for n in above + beneath], moved)
    return abs(right.row[:END_LINES].mean() - row)


def _leads(start, goal, below, layer):
    """Whether the goal lies below a layer, by way of others."""
    seen = {start}
    ways = [start]
    while ways:
        for lower in {layer[n] for n in below[ways.pop()]} - seen:
            if lower == goal:
                return True
            seen.add(lower)
            ways.append(lower)
    return False


def _whole(pieces, chosen):
    """Some pieces as one, from left to right."""
    members = [pieces[n] for n in np.flatnonzero(chosen)]
    members.sort(key=lambda piece: piece.line[0])
    arrays = ("line", "row", "excess")
    return Piece(*(np.concatenate([getattr(piece, name) for piece in members]) for name in arrays))


def _order(whole, layer, below):
    """Numbers of layers downwards; where that leaves the order open, by their mean row.

    Two that cross, on lines where one has no pick, lie below each other: of these and those beneath
    them the next is the one of the least mean row.
    """
    beneath = {number: {layer[n] for n in below[number]} for number in whole}
    n_above = dict.fromkeys(whole, 0)
    for number in (n for each in beneath.values() for n in each):
        n_above[number] += 1
    waiting = {number: whole[number].row.mean() for number in whole}
    order = []
    while waiting:
        free = [number for number in waiting if n_above[number] == 0]
        number = min(free or waiting, key=waiting.get)
        del waiting[number]
        order.append(number)
        for n in beneath[number]:
            n_above[n] -= 1
    return order
