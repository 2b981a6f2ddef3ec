"""Pieces of layers put in order, downwards, and joined through fades."""

import heapq

import numpy as np


def ordered(pieces):
    """Pieces downwards, such that of two on one line the upper comes first.

    Pieces do not cross, so what lies above what has no circles; where it leaves the order open, the
    piece with the lesser mean row comes first.
    """
    below = [set() for _ in pieces]
    n_above = np.zeros(len(pieces), dtype=int)
    start = np.array([piece.line[0] for piece in pieces])
    stop = np.array([piece.line[-1] for piece in pieces])
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
