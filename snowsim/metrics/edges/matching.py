"""Largest one-to-one matching of predicted to true pixels, kept exact while predicted pixels come and go.

State of the matching, arrays that the kernel changes in place:

`mate_of_pixel` (pixel)
    Of every pixel of the flattened map: its true pixel, `FREE` or, where it is not predicted,
    `ABSENT`.
`mate_of_truth` (true pixel)
    Its predicted pixel, or `FREE`.
`saturated` (true pixel)
    1 where the true pixel belongs to the saturated set S, which holds three properties: every
    member is matched; the neighbours of the mates of S lie in S; the neighbours of every unmatched
    predicted pixel lie in S. No augmenting path can then leave an unmatched pixel, so by Berge's
    theorem the matching is maximum. A search that fails adds what it saw to S; the loss of a
    predicted pixel costs a search only if its true pixel is in S, and a failure of that search
    takes what it saw out of S.
"""

import numpy as np
from numba import njit

FREE = -1
ABSENT = -2


class Matching:
    """Maximum-cardinality matching of a changing set of predicted pixels to true pixels within `radius` [pixels]."""

    def __init__(self, truth, radius):
        n_rows, n_lines = truth.shape
        self.n_truth = int(truth.sum())
        self.n_matched = 0
        # True pixels are numbered column by column, so those of a column within reach of a pixel
        # are consecutive: `first[line, row]` is the first one at or below a row.
        first_of_line = np.concatenate([[0], np.cumsum(truth.sum(axis=0))[:-1]])
        above = np.concatenate([np.zeros((1, n_lines), dtype=int), np.cumsum(truth, axis=0)])
        first = np.ascontiguousarray((above + first_of_line).T.astype(np.int32))
        lines, rows = np.nonzero(truth.T)
        pixel_of_truth = (rows * n_lines + lines).astype(np.int32)
        mates = (
            np.full(n, what, dtype=np.int32)
            for n, what in ((truth.size, ABSENT), (self.n_truth, FREE))
        )
        saturated = np.zeros(self.n_truth, dtype=np.uint8)
        self._state = (first, pixel_of_truth, reach_by_column(radius, n_lines), *mates, saturated)

    def update(self, removed, added):
        """Take predicted pixels away, then add others (flat indices), and return the number of matched pairs."""
        self.n_matched += _update(removed.astype(np.int32), added.astype(np.int32), *self._state)
        return self.n_matched


def reach_by_column(radius, n_lines):
    """How many rows a pixel reaches up and down in its own column, the next, ..., int (column offset,)."""
    columns = np.arange(min(int(radius), n_lines - 1) + 1)
    reach = np.floor(np.sqrt(np.maximum(radius * radius - columns**2, 0))).astype(np.int32)
    reach += (reach + 1) ** 2 + columns**2 <= radius * radius  # the root may have been rounded down
    return reach


@njit(cache=True)
def _update(removed, added, first, pixel_of_truth, reach, mate_of_pixel, mate_of_truth, saturated):
    """Change of the number of matched pairs; see the module for the state."""
    n_lines, n_rows = first.shape[0], first.shape[1] - 1
    n_truth = mate_of_truth.size
    change = 0
    seen = np.zeros(n_truth, dtype=np.int32)  # number of the last search that saw a true pixel
    search = 0
    queue = np.empty(n_truth + 1, dtype=np.int32)  # true pixels in the order seen
    back = np.empty(
        n_truth, dtype=np.int32
    )  # where a search came from: a pixel, or a true pixel when removing

    for pixel in removed:
        freed = mate_of_pixel[pixel]
        mate_of_pixel[pixel] = ABSENT
        if freed == FREE:
            continue
        mate_of_truth[freed] = FREE
        change -= 1
        if not saturated[freed]:
            continue
        search += 1
        seen[freed] = search
        back[freed] = FREE
        queue[0] = freed
        head, tail = 0, 1
        rescuer = ABSENT
        while head < tail and rescuer == ABSENT:
            here = queue[head]
            head += 1
            row, line = pixel_of_truth[here] // n_lines, pixel_of_truth[here] % n_lines
            for offset in range(1 - reach.size, reach.size):
                if not 0 <= line + offset < n_lines:
                    continue
                height = reach[abs(offset)]
                for near_row in range(max(row - height, 0), min(row + height, n_rows - 1) + 1):
                    near = near_row * n_lines + line + offset
                    mate = mate_of_pixel[near]
                    if mate == FREE:
                        rescuer = near
                        break
                    if mate != ABSENT and seen[mate] != search:
                        seen[mate] = search
                        back[mate] = here
                        queue[tail] = mate
                        tail += 1
                if rescuer != ABSENT:
                    break
            if rescuer != ABSENT:
                change += 1
                while here != FREE:
                    displaced = mate_of_truth[here]
                    mate_of_truth[here] = rescuer
                    mate_of_pixel[rescuer] = here
                    rescuer = displaced
                    here = back[here]
                rescuer = FREE
        if rescuer == ABSENT:
            for i in range(tail):
                saturated[queue[i]] = 0

    for pixel in added:
        mate_of_pixel[pixel] = FREE
        search += 1
        head, tail = -1, 0
        found = ABSENT
        while head < tail and found == ABSENT:
            here = pixel if head < 0 else mate_of_truth[queue[head]]
            head += 1
            row, line = here // n_lines, here % n_lines
            for turn in range(
                2 * reach.size - 1
            ):  # nearest columns first: offsets 0, -1, 1, -2, 2 ...
                offset = (turn + 1) // 2 * (1 - 2 * (turn % 2))
                if not 0 <= line + offset < n_lines:
                    continue
                height = reach[abs(offset)]
                start = first[line + offset, max(row - height, 0)]
                stop = first[line + offset, min(row + height + 1, n_rows)]
                for near in range(start, stop):
                    if saturated[near] or seen[near] == search:
                        continue
                    seen[near] = search
                    back[near] = here
                    if mate_of_truth[near] == FREE:
                        found = near
                        break
                    queue[tail] = near
                    tail += 1
                if found != ABSENT:
                    break
        if found == ABSENT:
            for i in range(tail):
                saturated[queue[i]] = 1
            continue
        change += 1
        while found != FREE:
            here = back[found]
            left = mate_of_pixel[here]
            mate_of_pixel[here] = found
            mate_of_truth[found] = here
            found = left
    return change
