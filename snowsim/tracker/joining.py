"""Joins pieces of one layer over gaps, and orders layers downwards."""

import numpy as np

from snowsim.tracker.linking import Piece

# Two pieces are one layer if the layers beside them predict the row at which the second begins.
# The largest error of this prediction grows with the gap between the pieces.
NEAREST_ROWS = 2.0  # largest error without a gap
ROWS_PER_LINE = 0.01  # its growth with the gap
MOST_ROWS = 4.0  # largest error over any gap
# Longest gap [range lines] in each round; layers joined in one round predict others in the next.
LONGEST_GAPS = (200, 800, 3200)
END_LINES = 10  # range lines at the end of a piece over which its row is averaged


def join(pieces):
    """Layers from the surface down, list of `Piece`, with pieces of one layer joined.

    Where a piece ends, the layers above and below it that continue predict its row where another
    piece begins, because neighbouring layers keep their distance. Two pieces are joined if each is
    the best match of the other, and no layer lies between them. The shortest gaps are closed first;
    gaps are not filled.
    """
    layer = np.arange(len(pieces))
    below = _next_below(pieces)
    for longest in LONGEST_GAPS:
        for _, left, right in sorted(_mutual_matches(pieces, layer, longest)):
            upper, lower = layer[left], layer[right]
            if _lies_below(upper, lower, below, layer) or _lies_below(lower, upper, below, layer):
                continue
            layer[layer == lower] = upper
            below[upper] |= below[lower]
    whole = {number: _joined_piece(pieces, layer == number) for number in np.unique(layer)}
    return [whole[number] for number in _order(whole, layer, below)]


def sort_downwards(pieces):
    """Pieces, list of `Piece`, in an order in which the upper of two on one line comes first."""
    order = _order(dict(enumerate(pieces)), range(len(pieces)), _next_below(pieces))
    return [pieces[number] for number in order]


def _ends(pieces):
    """First and last range line of every piece, (2, piece)."""
    ends = [piece.line[[0, -1]] for piece in pieces]
    return np.array(ends, dtype=int).reshape(-1, 2).T


def _rows_at(line, pieces, ends):
    """Rows of the pieces on a range line by number of the piece, a dict in downward order."""
    start, stop = ends
    there = np.flatnonzero((start <= line) & (line <= stop))
    rows = {n: pieces[n].filled[line - start[n]] for n in there}
    return {n: rows[n] for n in sorted(rows, key=rows.get)}


def _next_below(pieces):
    """Pieces that are next below each piece on some range line, list of sets."""
    below = [set() for _ in pieces]
    ends = _ends(pieces)
    # Neighbours change only where a piece begins or ends.
    for line in np.unique(ends):
        there = list(_rows_at(line, pieces, ends))
        for upper, lower in zip(there[:-1], there[1:], strict=True):
            below[upper].add(lower)
    return below


def _mutual_matches(pieces, layer, longest):
    """Tuples (gap, left, right) of two pieces that are each the best match of the other.

    `left` is the last piece of its layer and `right` the first of its own.
    """
    start, stop = ends = _ends(pieces)
    # Later entries of a dict replace earlier ones: in order of lines the last piece of a layer
    # stays, in reverse order the first.
    last = {layer[n]: n for n in np.argsort(start)}.values()
    first = np.array(list({layer[n]: n for n in np.argsort(-start)}.values()), dtype=int)
    at_begin = {n: _by_layer(_rows_at(start[n], pieces, ends), layer) for n in first}
    costs = []
    for left in last:
        at_end = _by_layer(_rows_at(stop[left], pieces, ends), layer)
        gap = start[first] - stop[left]
        for right in first[(gap > 0) & (gap <= longest)]:
            gap = int(start[right] - stop[left])
            miss = _row_error(pieces[left], pieces[right], at_end, at_begin[right])
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


def _row_error(left, right, at_end, at_begin):
    """Distance [rows] of the begin of a piece from the row predicted for an earlier piece.

    The layers next above and below the earlier piece predict it, by their rows where that piece
    ends, `at_end`, and where the other begins, `at_begin`.
    """
    row = left.row[-END_LINES:].mean()
    through = [n for n in at_end if n in at_begin]
    above = [n for n in through if at_end[n] < row][-1:]
    beneath = [n for n in through if at_end[n] >= row][:1]
    moved = [at_begin[n] - at_end[n] for n in above + beneath]
    if moved:
        row += np.interp(row, [at_end[n] for n in above + beneath], moved)
    return abs(right.row[:END_LINES].mean() - row)


def _lies_below(start, goal, below, layer):
    """True if the layer `goal` lies below the layer `start`, directly or by way of others."""
    seen = {start}
    ways = [start]
    while ways:
        for lower in {layer[n] for n in below[ways.pop()]} - seen:
            if lower == goal:
                return True
            seen.add(lower)
            ways.append(lower)
    return False


def _joined_piece(pieces, chosen):
    """Pieces of one layer as a single `Piece`, in order of range lines."""
    members = [pieces[n] for n in np.flatnonzero(chosen)]
    members.sort(key=lambda piece: piece.line[0])
    arrays = ("line", "row", "excess")
    return Piece(*(np.concatenate([getattr(piece, name) for piece in members]) for name in arrays))


def _order(whole, layer, below):
    """Numbers of layers in downward order; layers that share no line are ordered by mean row.

    Two layers that cross on lines where one has no pick each lie below the other. Of such layers
    and those beneath them, the one with the least mean row comes next.
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
