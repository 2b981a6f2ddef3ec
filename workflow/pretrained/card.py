"""What the card of the shipped tracker says of its scenes, its making and its scores."""

import hashlib
import platform
import subprocess

import numpy as np
import pandas as pd
import torch

LICENCE = "BSD-3-Clause"
COMMAND = "snakemake pretrained"
# Finest range bin of products of 2-8 GHz, 1.30 cm of air. Resampled, their pulses are of those that
# training saw: of picks with a confidence of .8 to .9 and above, .85 and .97 are right on a flight
# of 6 GHz in such bins (seed 1131, 24 scenes).
FINEST_BIN_S = 8.6e-11


def digest_of(network):
    """SHA-256 of the names and values of a network's weights."""
    digest = hashlib.sha256()
    for name, values in sorted(network.state_dict().items()):
        digest.update(name.encode())
        digest.update(values.cpu().numpy().tobytes())
    return digest.hexdigest()


def commit_of(folder):
    """Commit of a checkout, "-dirty" added where files differ from it; None of another folder."""
    command = ["git", "-C", folder, "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    told = subprocess.run(command, capture_output=True, text=True, check=False)
    return told.stdout.strip() or None


def making(network, commit, seed, benchmark):
    """How the weights were made, for the card; the table `benchmark` tells the time it took."""
    seconds = pd.read_csv(benchmark, sep="\t")["s"].sum()
    return {
        "weights": digest_of(network),
        "commit": commit,
        "command": COMMAND,
        "seed": seed,
        "processor": f"{platform.machine()}, {torch.backends.cpu.get_cpu_capability()}",
        "core_hours": round(seconds / 3600, 2),
        "licence": LICENCE,
    }


def ranges_of(statistics, ranges, firn):
    """Ranges of the scenes of training, (least, most) by name and unit.

    `ranges` are the `snowsim.statistics.Ranges` that variants of a flight's statistics are drawn
    from, `firn` the `pretrained.scenes.FirnRanges` of clean firn.
    """
    edges = statistics["zone_edge_bins"].values
    width_bins = float(statistics["width_bins"].values[0])
    surface_db = 10 * np.log10(float(statistics["peak_power"][0] / statistics["noise_power"]))
    quietest, loudest = ranges.noise_db
    # Two standard deviations of the spread from place to place.
    spread_db = 2 * float(statistics["surface_spread_db"])
    weakest_db = surface_db - loudest - spread_db
    strongest_db = surface_db - quietest + spread_db
    thinnest, thickest = ranges.thickness
    spans = {
        "first_layer_thickness_bins": (edges[0] * thinnest, edges[-1] * thickest),
        "surface_width_bins": [width_bins * factor for factor in ranges.pulse_length],
        "surface_to_noise_db": both((weakest_db, strongest_db), firn.surface_to_noise_db),
        "n_looks": both(ranges.n_looks, firn.n_looks),
        "line_gain_spread_db": ranges.line_gain_spread_db,
    }
    rounded = {name: [round(float(value), 1) for value in span] for name, span in spans.items()}
    shortest, longest = ranges.pulse_length
    bin_s = statistics.attrs["bin_size_s"]
    # Images are resampled to the range bins of the training, which saw pulses of as many bins.
    coarsest_s = float(f"{bin_s / shortest:.3g}")
    rounded["bin_s"] = [min(FINEST_BIN_S, float(f"{bin_s / longest:.3g}")), coarsest_s]
    # Closer range lines are averaged, so that there is no least spacing.
    farthest_m = ranges.line_spacing[1] * float(statistics.attrs["line_spacing_m"])
    rounded["line_spacing_m"] = [0.0, round(farthest_m, 1)]
    return rounded


def both(span, other):
    """Span (least, most) of what lies in one of two."""
    return min(span[0], other[0]), max(span[1], other[1])


def scores_for_card(paths):
    """Scores of the shipped tracker on unseen flights, a dict each, from a table if it was made."""
    for path in paths:
        table = pd.read_csv(path)
        kept = ["flight", "ods", "recall", "precision", "f", "missed_share", "false_share"]
        return table[kept].round(3).to_dict("records")
    return None
