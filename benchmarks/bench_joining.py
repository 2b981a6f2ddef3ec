"""Dates of years with and without joining of pieces over long gaps, on the tuning flights.

`PYTHONPATH=.:workflow python benchmarks/bench_joining.py TABLE` draws one long frame of each flight
of `pretrained.tuning` and picks it by the shipped tracker, with pieces joined by
`snowsim.tracker.joining.join` and with each as a layer of its own. It dates both, and writes a row
for each flight and way.
"""

import dataclasses
import sys
import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from pretrained.transfer import reference_of
from reference import checked_settings, draw_climate, draw_frame
from reference.settings import Settings
from snowsim import Tracker
from snowsim.seeding import random_stream
from snowsim.snowpack import accumulation
from snowsim.tracker import picks
from snowsim.tracker.joining import join, sort_downwards

N_LINES = 6144  # longer than any gap that is joined
N_PARTS = 8  # of the flight's line; the frame is one of them
PART = 3
NEAR_BINS = 4.0  # of a pick that is the horizon
SHIFTS = range(-4, 5)  # [years] by which all dates of a frame may be off
CONFIG = Path(__file__).resolve().parents[1] / "config/config.yaml"
WAYS = {"joined": join, "pieces": sort_downwards}


def dated(layers, truth, bin_s):
    """Share of true horizons (horizon, range line) that are dated rightly, and of dates, a dict.

    `found_shifted` is the share if all dates of the frame may be off by one and the same number of
    years. Without two horizons on a line nothing is dated.
    """
    flown = truth["slow_time"].values[0].astype("datetime64[Y]").astype(int) + 1970
    true_s = truth["twtt"].values[1:]
    scores = {"layers": layers.sizes["layer"] - 1, "found": 0.0, "found_shifted": 0.0}
    try:
        years = accumulation(layers, 340.0, temperature_k=243.0)
    except ValueError:
        return scores
    depth_m = years["depth_m"].values
    depth_at = years["depth_at"]
    own_s = np.interp(depth_m, depth_at.values, depth_at["below_s"].values)
    own_s += layers["twtt"].values[0]
    n_right = dict.fromkeys(SHIFTS, 0)
    for shift in SHIFTS:
        for age, horizon_s in enumerate(true_s):
            year = np.flatnonzero(years["year"].values == flown - 1 - age + shift)
            if year.size:
                near = np.abs(own_s[year] - horizon_s) < NEAR_BINS * bin_s
                n_right[shift] += near.sum()
    n_true = np.isfinite(true_s).sum()
    return scores | {
        "found": n_right[0] / n_true,
        "found_shifted": max(n_right.values()) / n_true,
    }


def main():
    """Write a row for each flight and way."""
    warnings.simplefilter("ignore")
    config = yaml.safe_load(CONFIG.read_text())
    default = dataclasses.asdict(Settings())
    tracker = Tracker.from_pretrained()
    rows = []
    for flight in config["pretrained"]["tuning"]:
        settings = checked_settings(reference_of(flight, default))
        climate = draw_climate(settings, rng=random_stream(flight["seed"], "climate"))
        rng = random_stream(flight["seed"], "bench_joining")
        echogram, truth = draw_frame(
            PART, N_PARTS, N_LINES, climate=climate, settings=settings, rng=rng
        )
        evidence = tracker.detect(echogram)
        for way, of_pieces in WAYS.items():
            picks.join = of_pieces
            (layers,) = tracker.pick_together([evidence])
            scores = dated(layers, truth, settings.radar.bin_size_s)
            rows.append({"flight": flight["name"], "way": way} | scores)
    table = pd.DataFrame(rows)
    table.to_csv(sys.argv[1], index=False, float_format="%.3f")
    print(table.groupby("way").mean(numeric_only=True).round(3).to_string())  # noqa: T201


if __name__ == "__main__":
    main()
