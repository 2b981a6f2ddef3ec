"""The card of a tracker: what it was trained for and within, in terms that a reader understands."""

import numpy as np

VERSION = "1"
SYNTHETIC = "trained on synthetic scenes only; never scored on an annotated real frame"
INPUT = (
    "image: float32 (n, 1, range_bin, range_line), 2 / 255 * grey - 1 of an 8-bit image, surface "
    "near row 50; grey is linear in dB, 0 at 10 dB below the noise floor (the least mean of a row "
    "in dB), 255 at the maximum"
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
    """Card of a tracker with its `Calibration`, as a dict of what JSON holds.

    `bin_s` [s], `line_spacing_m` [m] and `n_looks` are those of the scenes it was trained on, or of
    most of them; `ranges` span them, (least, most) by name and unit, `scores` are those of unseen
    flights, `confidence` the coefficients of `snowsim.picking.confidence`, None: those of the
    package. What else is not known is None.
    """
    card = {
        "name": name,
        "version": VERSION,
        "trained_on": trained_on,
        "input": INPUT,
        "output": OUTPUT,
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
    """What `snowsim.statistics.varied` scenes of a flight span, (least, most) by name and unit."""
    edges = statistics["zone_edge_bins"].values
    width_bins = float(statistics["width_bins"].values[0])
    surface_db = 10 * np.log10(float(statistics["peak_power"][0] / statistics["noise_power"]))
    quietest, loudest = ranges.noise_db
    # Two standard deviations from place to place.
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
    # Range bins are brought to those of the training: a pulse shown in fewer bins was in it.
    rounded["bin_s"] = [float(f"{bin_s / longest:.3g}"), float(f"{bin_s / shortest:.3g}")]
    # Lines nearer to each other are averaged.
    farthest_m = ranges.line_spacing[1] * float(statistics.attrs["line_spacing_m"])
    rounded["line_spacing_m"] = [0.0, round(farthest_m, 1)]
    return rounded
