"""Largest one-to-one matching of predicted to true pixels, exact after each change of the map.

`State` holds the arrays that the compiled functions change in place. Three of them are the
matching:

`mate_of_pixel` (pixel)
    For every pixel of the flattened map: its true pixel, `FREE` if a predicted pixel has none, or
    `ABSENT` if the pixel is not predicted.
`mate_of_truth` (true pixel)
    For every true pixel: its predicted pixel, or `FREE`.
`saturated` (true pixel)
    1 where the true pixel belongs to the saturated set S. This set has three properties: every
    member is matched; the neighbours of the mates of S lie in S; the neighbours of every unmatched
    predicted pixel lie in S. No augmenting path can then leave an unmatched pixel, so by Berge's
    theorem the matching is maximum. A search that fails adds the true pixels it saw to S. The loss
    of a predicted pixel costs a search only if its true pixel is in S; if that search fails, the
    true pixels it saw leave S.
"""

from typing import NamedTuple

import numpy as np

from snowsim.compiling import compiled

FREE = -1
ABSENT = -2


class State(NamedTuple):
    """Arrays of the matching (see the module), of the geometry, and of searches."""

    mate_of_pixel: np.ndarray
    mate_of_truth: np.ndarray
    saturated: np.ndarray
    # (line, row): number of the first true pixel of the line at this row or below. True pixels are
    # numbered column by column, so those of one column near a pixel have consecutive numbers.
    first: np.ndarray
    pixel_of_truth: np.ndarray
    reach: np.ndarray  # (column offset): see `reach_by_column`
    seen: np.ndarray  # (true pixel): number of the last search that saw it
    back: np.ndarray  # (true pixel): the pixel, or true pixel, from which that search came
    queue: np.ndarray  # true pixels in the order seen


class Matching:
    """Largest matching of a changing set of predicted to true pixels within `radius` [pixels]."""

    def __init__(self, truth, radius):
        n_lines = truth.shape[1]
        self.n_truth = int(truth.sum())
        self.n_matched = 0
        self._n_searches = 0
        first_of_line = np.concatenate([[0], np.cumsum(truth.sum(axis=0))[:-1]])
        above = np.concatenate([np.zeros((1, n_lines), dtype=int), np.cumsum(truth, axis=0)])
        lines, rows = np.nonzero(truth.T)
        self._state = State(
            mate_of_pixel=np.full(truth.size, ABSENT, dtype=np.int32),
            mate_of_truth=np.full(self.n_truth, FREE, dtype=np.int32),
            saturated=np.zeros(self.n_truth, dtype=np.uint8),
            first=np.ascontiguousarray((above + first_of_line).T.astype(np.int32)),
            pixel_of_truth=(rows * n_lines + lines).astype(np.int32),
            reach=reach_by_column(radius, n_lines),
            seen=np.zeros(self.n_truth, dtype=np.int32),
            back=np.empty(self.n_truth, dtype=np.int32),
            queue=np.empty(self.n_truth, dtype=np.int32),
        )

    def update(self, removed, added):
        """Remove and add predicted pixels (flat indices), and return the number of pairs."""
        removed = removed.astype(np.int32)
        added = added.astype(np.int32)
        self.n_matched += _update(removed, added, self._n_searches, *self._state)
        self._n_searches += removed.size + added.size
        return self.n_matched


def reach_by_column(radius, n_lines):
    """Largest distance in rows of paired pixels, by their distance in columns, (column offset,).

    Pairs lie within `radius` [pixels] of each other.
    """
    columns = np.arange(min(int(radius), n_lines - 1) + 1)
    reach = np.floor(np.sqrt(np.maximum(radius * radius - columns**2, 0))).astype(np.int32)
    reach += (reach + 1) ** 2 + columns**2 <= radius * radius  # the root may have been rounded down
    return reach


@compiled()
def _update(
    removed, added, search,
    mate_of_pixel, mate_of_truth, saturated, first, pixel_of_truth, reach, seen, back, queue,
):  # fmt: skip
    """Change in the number of pairs by pixels removed and added; updates the state in place.

    `search` is the number of the last search before this call.
    """
    state = State(
        mate_of_pixel, mate_of_truth, saturated, first, pixel_of_truth, reach, seen, back, queue
    )  # Arrays are passed one by one: a named tuple costs more to pass than a small update.
    change = 0
    for pixel in removed:
        freed = state.mate_of_pixel[pixel]
        state.mate_of_pixel[pixel] = ABSENT
        if freed == FREE:
            continue
        state.mate_of_truth[freed] = FREE
        change -= 1
        if state.saturated[freed]:
            search += 1
            change += _match_truth(freed, search, state)
    for pixel in added:
        state.mate_of_pixel[pixel] = FREE
        search += 1
        change += _match_pixel(pixel, search, state)
    return change


@compiled(inline="always")
def _match_truth(freed, search, state):
    """Find a mate for a true pixel that lost its mate; 1 if there is an augmenting path, else 0."""
    state.seen[freed] = search
    state.back[freed] = FREE
    state.queue[0] = freed
    head, tail = 0, 1
    while head < tail:
        here = state.queue[head]
        head += 1
        free, tail = _free_pixel_near(here, tail, search, state)
        if free == ABSENT:
            continue
        while here != FREE:
            displaced = state.mate_of_truth[here]
            state.mate_of_truth[here] = free
            state.mate_of_pixel[free] = here
            free = displaced
            here = state.back[here]
        return 1
    for i in range(tail):
        state.saturated[state.queue[i]] = 0
    return 0


@compiled(inline="always")
def _free_pixel_near(here, tail, search, state):
    """An unmatched predicted pixel near a true one, or `ABSENT`, and the new end of the queue.

    If predicted pixels nearby are matched, their true pixels join the queue.
    """
    n_lines, n_rows = state.first.shape[0], state.first.shape[1] - 1
    row, line = state.pixel_of_truth[here] // n_lines, state.pixel_of_truth[here] % n_lines
    for offset in range(1 - state.reach.size, state.reach.size):
        if not 0 <= line + offset < n_lines:
            continue
        height = state.reach[abs(offset)]
        for near_row in range(max(row - height, 0), min(row + height, n_rows - 1) + 1):
            near = near_row * n_lines + line + offset
            mate = state.mate_of_pixel[near]
            if mate == FREE:
                return near, tail
            if mate != ABSENT and state.seen[mate] != search:
                state.seen[mate] = search
                state.back[mate] = here
                state.queue[tail] = mate
                tail += 1
    return ABSENT, tail


@compiled(inline="always")
def _match_pixel(pixel, search, state):
    """Find a mate for an added predicted pixel; 1 if there is an augmenting path, else 0."""
    here = pixel
    head = tail = 0
    while True:
        free, tail = _free_truth_near(here, tail, search, state)
        if free != ABSENT:
            break
        if head == tail:
            for i in range(tail):
                state.saturated[state.queue[i]] = 1
            return 0
        here = state.mate_of_truth[state.queue[head]]
        head += 1
    while free != FREE:
        here = state.back[free]
        left = state.mate_of_pixel[here]
        state.mate_of_pixel[here] = free
        state.mate_of_truth[free] = here
        free = left
    return 1


@compiled(inline="always")
def _free_truth_near(here, tail, search, state):
    """An unmatched true pixel near a predicted one, or `ABSENT`, and the new end of the queue.

    Matched true pixels nearby join the queue.
    """
    n_lines, n_rows = state.first.shape[0], state.first.shape[1] - 1
    row, line = here // n_lines, here % n_lines
    for turn in range(2 * state.reach.size - 1):
        # Nearest columns first: offsets 0, -1, 1, -2, 2 ...
        offset = (turn + 1) // 2 * (1 - 2 * (turn % 2))
        if not 0 <= line + offset < n_lines:
            continue
        height = state.reach[abs(offset)]
        start = state.first[line + offset, max(row - height, 0)]
        stop = state.first[line + offset, min(row + height + 1, n_rows)]
        for near in range(start, stop):
            if state.saturated[near] or state.seen[near] == search:
                continue
            state.seen[near] = search
            state.back[near] = here
            if state.mate_of_truth[near] == FREE:
                return near, tail
            state.queue[tail] = near
            tail += 1
    return ABSENT, tail
