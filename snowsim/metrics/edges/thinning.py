"""Thinning of binary maps by a look-up table that visits only pixels with changed neighbours."""

import numpy as np

from snowsim.compiling import compiled

# Neighbours of a pixel, anticlockwise from the right: neighbour k sets bit k of its 8-bit code.
NEIGHBOURS = ((0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0), (1, 1))


def _deletable_codes():
    """Table of neighbour codes with which each half-step removes a pixel, bool (2, 256).

    Conditions G1-G3 of algorithm A1 of Guo & Hall (1989), Commun. ACM 32, as in Lam, Lee & Suen
    (1992), IEEE TPAMI 14.
    """
    on = (np.arange(256) >> np.arange(8)[:, None]) & 1 == 1
    x1, x2, x3, x4, x5, x6, x7, x8 = on
    sides = on[::2]  # x1, x3, x5, x7, each followed by a corner
    corners = on[1::2]
    next_sides = np.roll(sides, -1, axis=0)
    crossings = np.sum(~sides & (corners | next_sides), axis=0)
    ahead = np.sum(sides | corners, axis=0)
    behind = np.sum(corners | next_sides, axis=0)
    fewest = np.minimum(ahead, behind)
    common = (crossings == 1) & (fewest >= 2) & (fewest <= 3)
    first = ~((x2 | x3 | ~x8) & x1)
    second = ~((x6 | x7 | ~x4) & x5)
    return common & np.stack([first, second])


DELETABLE = _deletable_codes()


def neighbour_steps(row_length):
    """Flat-index differences to the `NEIGHBOURS` in a map with rows of `row_length`, (8,)."""
    return np.array([row * row_length + line for row, line in NEIGHBOURS])


@compiled()
def switch_on(pixels, on, codes, steps):
    """Turn pixels on in a flattened map with a border, and in the codes of their neighbours.

    Both arrays change in place.
    """
    for pixel in pixels:
        on[pixel] = 1
        for k in range(8):
            codes[pixel - steps[k]] |= np.uint8(1 << k)


@compiled()
def thin_pixels(pixels, on, codes, steps, deletable):
    """Thin the flattened map `on`, which has a border, and its `codes` in place.

    `pixels` are the flat indices of all pixels that are on. Thinning stops as soon as one of the
    two half-steps removes nothing, as in the Python port of the Berkeley benchmark (py-bsds500).
    scikit-image and MATLAB stop only when both remove nothing, which leaves a few pixels fewer.
    """
    # Pixels that each half-step still has to visit.
    queues = np.empty((2, pixels.size), dtype=pixels.dtype)
    queues[:] = pixels
    lengths = np.array([pixels.size, pixels.size])
    queued = on * np.uint8(3)
    falling = np.empty(pixels.size, dtype=pixels.dtype)
    half = 0
    while lengths[0] + lengths[1] > 0:
        n_falling = 0
        for i in range(lengths[half]):
            pixel = queues[half, i]
            queued[pixel] &= ~np.uint8(1 << half)
            if on[pixel] and deletable[half, codes[pixel]]:
                falling[n_falling] = pixel
                n_falling += 1
        if n_falling == 0:
            return
        lengths[half] = 0
        # Pixels are removed together: each decision above saw the map before the half-step.
        for i in range(n_falling):
            on[falling[i]] = 0
        for i in range(n_falling):
            for k in range(8):
                neighbour = falling[i] - steps[k]
                codes[neighbour] &= ~np.uint8(1 << k)
                if on[neighbour]:
                    for other in range(2):
                        if not queued[neighbour] & np.uint8(1 << other):
                            queued[neighbour] |= np.uint8(1 << other)
                            queues[other, lengths[other]] = neighbour
                            lengths[other] += 1
        half = 1 - half
