"""What the card of the shipped tracker says of its scenes and scores."""

import numpy as np
import pandas as pd


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


def scores_for_card(paths):
    """Scores of the shipped tracker on unseen flights, a dict each, from a table if it was made."""
    for path in paths:
        table = pd.read_csv(path)
        kept = ["flight", "ods", "recall", "precision", "f", "missed_share", "false_share"]
        return table[kept].round(3).to_dict("records")
    return None
