"""A network of an ONNX file, run over a whole echogram in windows that overlap.

Pooling reduces by 16, of range lines that may have been averaged in pairs: windows that begin on a
grid of so many pixels and overlap by more than a pixel sees give what the whole gives.
"""

import numpy as np

from snowsim.progress import shown

GRID_ROWS = 16
GRID_LINES = 2 * GRID_ROWS
# Farther than a pixel sees: 98 pixels, by the last stage's convolutions, and at most 23 of its
# up-sampling.
MARGIN_ROWS = 8 * GRID_ROWS
MARGIN_LINES = 8 * GRID_LINES
WINDOW_ROWS = 64 * GRID_ROWS
WINDOW_LINES = 64 * GRID_LINES
NEEDED = "tracking needs onnxruntime: pip install 'snowsim[track]'"


def runner(weights, temperature=1.0, where="weights"):
    """Log-odds of a stack of inputs, both float32 (patch, 1, row, range_line), as a function.

    They are the logits of a network (bytes of an ONNX file), run by onnxruntime on one thread, over
    a temperature. ValueError where onnxruntime is missing, or finds no network of this input.
    """
    try:
        import onnxruntime
    except ImportError as error:
        raise ValueError(NEEDED) from error
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    options.inter_op_num_threads = 1
    # Windows differ in size: what was kept for the largest would stay.
    options.enable_cpu_mem_arena = False
    try:
        session = onnxruntime.InferenceSession(weights, options, ["CPUExecutionProvider"])
    except Exception as error:  # of a kind that onnxruntime does not export
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
    """First range line, log-odds and image (row, range_line) of stretches of range lines, in order.

    `run` gives log-odds of a stack of inputs, `image_of(first, stop)` the 8-bit image (row,
    range_line) of range lines; no more than a window of either is in memory.
    """
    for first in shown(range(0, n_lines, WINDOW_LINES), unit="window"):
        stop = min(first + WINDOW_LINES, n_lines)
        left = max(0, first - MARGIN_LINES)
        image = image_of(left, min(stop + MARGIN_LINES, n_lines))
        log_odds = np.empty((n_rows, stop - first), dtype=np.float32)
        for top in range(0, n_rows, WINDOW_ROWS):
            bottom = min(top + WINDOW_ROWS, n_rows)
            above = max(0, top - MARGIN_ROWS)
            window = image[above : min(bottom + MARGIN_ROWS, n_rows)]
            found = run(to_input(window))[0, 0]
            rows = slice(top - above, bottom - above)
            log_odds[top:bottom] = found[rows, first - left : stop - left]
        yield first, log_odds, image[:, first - left : stop - left]


def to_input(image):
    """Float32 (1, 1, row, range_line) in [-1, 1] of an 8-bit image, as in training."""
    signed = image.astype(np.float32) * np.float32(2 / 255) - np.float32(1)
    return signed[None, None]
