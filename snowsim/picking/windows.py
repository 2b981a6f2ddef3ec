"""Log-odds of layers over a whole echogram, by windows that overlap.

Pooling reduces by 16: windows that begin on a grid of 16 pixels and overlap by more than a pixel
sees give what the whole gives.
"""

import numpy as np

GRID = 16
# Farther than a pixel sees: 98 pixels, by the last stage's convolutions, and 16 of its up-sampling.
MARGIN = 8 * GRID
WINDOW_LINES = 64 * GRID
WINDOW_ROWS = 64 * GRID


def log_odds_by_lines(
    run, image_of, n_rows, n_lines, *, window_lines=WINDOW_LINES, window_rows=WINDOW_ROWS
):
    """First range line and log-odds (row, range_line) of stretches of range lines, in order.

    `run` gives log-odds of a stack of inputs, `image_of(first, stop)` the 8-bit image (row,
    range_line) of range lines; no more than a window of either is in memory. Windows are whole
    multiples of `GRID`.
    """
    for first in range(0, n_lines, window_lines):
        stop = min(first + window_lines, n_lines)
        left = max(0, first - MARGIN)
        image = image_of(left, min(stop + MARGIN, n_lines))
        log_odds = np.empty((n_rows, stop - first), dtype=np.float32)
        for top in range(0, n_rows, window_rows):
            bottom = min(top + window_rows, n_rows)
            above = max(0, top - MARGIN)
            window = image[above : min(bottom + MARGIN, n_rows)]
            found = run(to_input(window))[0, 0]
            rows = slice(top - above, bottom - above)
            log_odds[top:bottom] = found[rows, first - left : stop - left]
        yield first, log_odds


def to_input(image):
    """Float32 (1, 1, row, range_line) in [-1, 1] of an 8-bit image, as in training."""
    signed = image.astype(np.float32) * np.float32(2 / 255) - np.float32(1)
    return signed[None, None]
