"""Runs the network of an ONNX file over a whole echogram in overlapping windows.

The result is that of one run over the whole: windows begin on the grid of the coarsest pooling, of
16 rows and, since the network may average pairs of range lines, 32 lines. They overlap by more than
the distance from which an output pixel depends on the image.
"""

from functools import partial

import numpy as np

from snowsim.progress import with_progress

GRID_ROWS = 16
GRID_LINES = 2 * GRID_ROWS
# More than the 121 pixels on which an output depends: 98 through the convolutions of the last stage
# and at most 23 through its enlargement.
MARGIN_ROWS = 8 * GRID_ROWS
MARGIN_LINES = 8 * GRID_LINES
WINDOW_ROWS = 64 * GRID_ROWS
WINDOW_LINES = 64 * GRID_LINES


def runner(weights, temperature=1.0, where="weights"):
    """Function that gives log-odds of inputs, both float32 (patch, 1, row, range_line).

    Log-odds are the logits of the network in `weights`, bytes of an ONNX file, divided by
    `temperature`; onnxruntime runs on one thread. ValueError if onnxruntime is missing, or the file
    is no such network.
    """
    try:
        import onnxruntime
    except ImportError as error:
        msg = "tracking needs onnxruntime: pip install 'snowsim[track]'"
        raise ValueError(msg) from error
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    options.inter_op_num_threads = 1
    # Frames differ in their numbers of rows: memory planned for one shape would be asked for anew.
    options.enable_mem_pattern = False
    try:
        session = onnxruntime.InferenceSession(weights, options, ["CPUExecutionProvider"])
    except Exception as error:  # onnxruntime does not export its errors
        msg = f"{where}: expected an ONNX network, {type(error).__name__}"
        raise ValueError(msg) from error
    inputs = [each.name for each in session.get_inputs()]
    outputs = [each.name for each in session.get_outputs()]
    if (inputs, outputs) != (["image"], ["logit"]):
        msg = f"{where}: expected input image and output logit, found {inputs} and {outputs}"
        raise ValueError(msg)

    def run(images):
        (logits,) = session.run(["logit"], {"image": images})
        return logits / np.float32(temperature)

    return run


def log_odds_by_lines(run, image_of, n_rows, n_lines):
    """Yield first range line, log-odds and image (row, range_line) of each stretch of lines.

    `n_rows` are those of the image; the other arguments are those of `stretches`.
    """
    for first, image, log_odds_of in stretches(run, image_of, n_lines):
        yield first, log_odds_of(n_rows), image


def stretches(run, image_of, n_lines):
    """Yield first range line, image, and function that gives log-odds, of each stretch of lines.

    `run` gives log-odds of a stack of inputs, and `image_of(first, stop)` the 8-bit image (row,
    range_line) of range lines. The function takes a number of rows and gives log-odds of so many
    from the top. Only one window of either is in memory.
    """
    for first in with_progress(range(0, n_lines, WINDOW_LINES), unit="window"):
        stop = min(first + WINDOW_LINES, n_lines)
        left = max(0, first - MARGIN_LINES)
        image = image_of(left, min(stop + MARGIN_LINES, n_lines))
        lines = slice(first - left, stop - left)
        yield first, image[:, lines], partial(_log_odds, run, image, lines)


def _log_odds(run, image, lines, n_rows):
    """Log-odds (row, range_line) of the upper `n_rows` rows and some lines of an 8-bit image."""
    log_odds = np.empty((n_rows, lines.stop - lines.start), dtype=np.float32)
    # The rows of all windows but the last of the image begin and end on the grid of the pooling.
    n_computed = min(-(-n_rows // GRID_ROWS) * GRID_ROWS, len(image))
    for top in range(0, n_rows, WINDOW_ROWS):
        bottom = min(top + WINDOW_ROWS, n_computed)
        above = max(0, top - MARGIN_ROWS)
        window = image[above : bottom + MARGIN_ROWS]
        found = run(to_input(window))[0, 0, :, lines]
        log_odds[top:bottom] = found[top - above : min(bottom, n_rows) - above]
    return log_odds


def to_input(image):
    """Input of the network, float32 (1, 1, row, range_line) in [-1, 1], of an 8-bit image."""
    signed = image.astype(np.float32) * np.float32(2 / 255) - np.float32(1)
    return signed[None, None]
