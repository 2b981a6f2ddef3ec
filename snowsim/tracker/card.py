"""The card of a tracker: its input and output, what it was trained on, its limits and scores."""

VERSION = "3"
SYNTHETIC = "trained on synthetic scenes only; never scored on an annotated real frame"
INPUT = (
    "image: float32 (n, 1, range_bin, range_line), 2 / 255 * grey - 1 of an 8-bit image, surface "
    "near row 50; grey is linear in dB, 0 at 10 dB below the noise floor (the least mean of a row "
    "in dB), 255 at the maximum"
)
QUALITY = (
    "quality 1: confidence of 0.8 or more that a layer lies within 2 of the tracker's range bins, "
    "as calibrated on synthetic flights; never where bin_s, line_spacing_m or n_looks lie outside "
    "the ranges"
)
OUTPUT = "logit: the same shape; probability of a layer is sigmoid(logit / temperature)"


def make_card(
    name,
    calibration,
    *,
    trained_on,
    bin_s,
    line_spacing_m,
    n_looks,
    ranges,
    scores,
    limits,
    confidence=None,
):
    """Card of a tracker with its `Calibration`, a dict that JSON can hold.

    `bin_s` [s], `line_spacing_m` [m] and `n_looks` are those of most scenes it was trained on;
    `ranges` gives the (least, most) of all scenes by name and unit. `scores` are those on unseen
    flights. `confidence` has the coefficients of `snowsim.picking.confidence`; with None the
    package's own apply. Other arguments are None where they are not known.
    """
    card = {
        "name": name,
        "version": VERSION,
        "trained_on": trained_on,
        "input": INPUT,
        "output": OUTPUT,
        "quality": QUALITY,
        "bin_s": bin_s,
        "line_spacing_m": line_spacing_m,
        "n_looks": n_looks,
        "temperature": round(calibration.temperature, 6),
        "threshold": round(calibration.threshold, 6),
        "calibration_ods": round(calibration.ods, 4),
        "calibration_deviation": round(calibration.deviation, 4),
        "ranges": ranges,
        "scores": scores,
        "limits": limits,
    }
    if confidence is not None:
        card["confidence"] = [round(value, 4) for value in confidence]
    return card
