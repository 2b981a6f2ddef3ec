"""Share of picks that are right, by their confidence and by kind of simulated firn.

`python benchmarks/bench_confidence.py` tracks twenty annual layers as two radars see them, with and
without crusts, prints a table and writes `confidence_by_case.csv` beside this file. Nothing was
chosen on these seeds. A pick is right within 2 of the tracker's range bins of the peak of a layer's
echo; crusts are layers, too, and `right_years` counts annual layers alone.
"""

from pathlib import Path

import numpy as np
import pandas as pd
from bench_years import firn

from snowsim import Tracker
from snowsim.seeding import random_stream
from snowsim.snowpack import Radar, simulate

RADARS = ("snow-2012", "snow-2-8")
ACCUMULATIONS_M = (0.15, 0.3, 0.45, 0.6)
N_CRUSTS = (0, 5)  # in twenty years
SEEDS = range(770_000, 770_004)
EDGES = (0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)  # of classes of confidence; the first is the rest
WITHIN_BINS = 2
CASE = ["radar", "accumulation_m", "n_crusts"]


def picks(tracker, radar, accumulation_m, n_crusts, seed):
    """Confidence of every pick below the surface, and whether it is right, one a row."""
    rng = random_stream(seed, "bench_confidence", radar, accumulation_m, n_crusts)
    preset = Radar.preset(radar)
    snow, is_year = firn(accumulation_m, n_crusts, preset.line_spacing_m, rng)
    echogram, truth = simulate(snow, preset, rng=rng)
    found = tracker.pick(echogram)
    true_s = truth["peak_twtt"].values
    away_s = np.abs(found["twtt"].values[1:, None] - true_s)  # (pick, true layer, range_line)
    near = away_s <= WITHIN_BINS * tracker.card.bin_s
    picked = np.isfinite(found["twtt"].values[1:])
    columns = {
        "confidence": found["confidence"].values[1:][picked],
        "right": near.any(axis=1)[picked],
        "right_years": near[:, is_year].any(axis=1)[picked],
    }
    case = dict(zip(CASE, (radar, accumulation_m, n_crusts), strict=True))
    return pd.DataFrame(columns).assign(**case, seed=seed)


def main():
    """Track, count and write."""
    tracker = Tracker.from_pretrained("universal")
    tables = [
        picks(tracker, radar, accumulation_m, n_crusts, seed)
        for radar in RADARS
        for accumulation_m in ACCUMULATIONS_M
        for n_crusts in N_CRUSTS
        for seed in SEEDS
    ]
    rows = pd.concat(tables)
    rows["from"] = pd.cut(rows["confidence"], [0, *EDGES[1:]], labels=EDGES[:-1]).astype(float)
    by_class = rows.groupby([*CASE, "from"])
    table = by_class[["confidence", "right", "right_years"]].mean().round(3)
    table.insert(0, "n_picks", by_class.size())
    path = Path(__file__).with_name("confidence_by_case.csv")
    table.to_csv(path, lineterminator="\n")
    shown = table["right"].unstack("from")
    print(shown.round(2).to_string(na_rep="-"))  # noqa: T201
    print(table["right_years"].unstack("from").round(2).to_string(na_rep="-"))  # noqa: T201
    print(table["n_picks"].unstack("from").to_string(na_rep="-"))  # noqa: T201
    print(path)  # noqa: T201


if __name__ == "__main__":
    main()
