"""The card of a tracker: its input and output, what it was trained on, its limits and scores."""

import numpy as np

VERSION = "2"
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


def ranges_of(statistics, ranges):
    """Ranges of `snowsim.statistics.varied` scenes of a flight, (least, most) by name and unit.

    `ranges` are the `snowsim.statistics.Ranges` that these scenes are drawn from.
    """
    edges = statistics["zone_edge_bins"].values
    width_bins = float(statistics["width_bins"].values[0])
    surface_db = 10 * np.log10(float(statistics["peak_power"][0] / statistics["noise_power"]))
    quietest, loudest = ranges.noise_db
    # Two standard deviations of the spread from place to place.
    spread_db = 2 * float(statistics["surface_to_noise_spread_db"])
    weakest_db = surface_db - loudest - spread_db
    strongest_db = surface_db - quietest + spread_db
    thinnest, thickest = ranges.thickness
    spans = {
        "first_layer_thickness_bins": (edges[0] * thinnest, edges[-1] * thickest),
        "surface_width_bins": [width_bins * factor for factor in ranges.pulse_length],
        "surface_to_noise_db": (weakest_db, strongest_db),
        "n_looks": ranges.n_looks,
        "line_gain_spread_db": ranges.line_gain_spread_db,
    }
    rounded = {name: [round(float(value), 1) for value in span] for name, span in spans.items()}
    shortest, longest = ranges.pulse_length
    bin_s = statistics.attrs["bin_size_s"]
    # Images are resampled to the range bins of the training, which saw pulses of as many bins.
    rounded["bin_s"] = [float(f"{bin_s / longest:.3g}"), float(f"{bin_s / shortest:.3g}")]
    # Closer range lines are averaged, so that there is no least spacing.
    farthest_m = ranges.line_spacing[1] * float(statistics.attrs["line_spacing_m"])
    rounded["line_spacing_m"] = [0.0, round(farthest_m, 1)]
    return rounded
