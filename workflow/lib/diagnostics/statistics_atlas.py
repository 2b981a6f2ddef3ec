"""The stability atlas of the estimators: planted flights pushed to where one or both lose what was planted.

A row has `panel, value, estimator, quantity`, mean `error` over layers against what was planted, its `largest`
magnitude, the mean `standard_error` claimed, `unit`, `bound`, the `outcome` and, as `note`, the rule that degraded the
result or the line that refused it. Outcomes: ``within`` the bound, ``beyond`` it, ``refused`` by a ValueError, ``not
finite``, which must not be.
"""

from dataclasses import replace

import numpy as np
import pandas as pd

from lib.diagnostics.planted import Planted, judged
from snowsim.statistics.estimate import ESTIMATORS

PANEL = "borders"  # of the panels the one that is no sweep
GAP_LINES = 24  # mean length of a gap in a layer's picks [range lines]
COLUMNS = (
    *("panel", "value", "estimator", "quantity", "error", "largest", "standard_error"),
    *("unit", "bound", "outcome", "note"),
)


def _noisy(value):
    weakest = min(Planted().peak_power)
    return Planted(noise_power=weakest * 10 ** (-value / 10))


# Values of each sweep, and the flight planted for one.
SWEEPS = {
    "slab thickness [bins]": ((3, 5, 8, 12, 18, 27, 44, 80), lambda value: Planted(slab_bins=value)),
    "weakest layer over noise [dB]": ((-15, -10, -5, 0, 5, 10, 20, 30), _noisy),
    "looks of a range line": ((0.2, 0.5, 1, 2, 5, 20, 100), lambda value: Planted(n_looks=value)),
    "range lines of a flight": ((200, 256, 512, 1024, 2048, 4096), lambda value: Planted(n_frames=1, n_lines=value)),
    "share of picks missing": ((0, 0.2, 0.4, 0.6, 0.8, 0.95), lambda _: Planted()),
}


def sweep(panel, stream, *, share=1.0):
    """Rows of one panel of `SWEEPS`: every value by every estimator, from the same flight.

    `stream` gives the random generator of a panel and a value; `share` of the values, spread evenly, both ends
    included, are run.
    """
    values, plant = SWEEPS[panel]
    chosen = np.unique(np.linspace(0, len(values) - 1, max(int(np.ceil(share * len(values))), 2)).round().astype(int))
    rows = []
    for value in (values[i] for i in chosen):
        planted = plant(value)
        rng = stream(panel, value)
        frames = list(planted.frames(rng))
        if panel == "share of picks missing":
            frames = [with_gaps(frame, value, rng) for frame in frames]
        for estimator in ESTIMATORS:
            rows += judged(panel, float(value), planted, frames, estimator)
    return rows


def with_gaps(frame, share, rng):
    """A frame whose buried layers lose this share of their picks, in runs of `GAP_LINES` on average."""
    echogram, layers = frame
    layers = layers.copy(deep=True)
    if share > 0:
        n_layers, n_lines = layers["twtt"].shape
        leave, enter = 1 / GAP_LINES, share / max(1 - share, 1e-9) / GAP_LINES
        missing = rng.random(n_layers) < share
        for line in range(n_lines):
            turn = rng.random(n_layers)
            missing = np.where(missing, turn >= leave, turn < min(enter, 1.0))
            layers["twtt"].values[1:, line] = np.where(missing[1:], np.nan, layers["twtt"].values[1:, line])
    return echogram, layers


def _picks(frames, change):
    """Frames whose travel times of layers are changed in place by a function of (frame, twtt)."""
    changed = []
    for index, (echogram, layers) in enumerate(frames):
        layers = layers.copy(deep=True)
        change(index, layers["twtt"].values)
        changed.append((echogram, layers))
    return changed


def _without(layer, lines=slice(None), first_frame=0):
    """A change that removes picks of a layer (or a slice of them) from a frame on."""

    def change(index, twtt):
        if index >= first_frame:
            twtt[layer, lines] = np.nan

    return change


def _crossed(_, twtt):
    twtt[2, 100] = twtt[3, 100] + 1e-9


def _lost_lines(frame):
    """A frame with every third group of lines not recorded."""
    echogram, layers = frame
    echogram = echogram.copy(deep=True)
    lost = (np.arange(echogram.sizes["slow_time"]) // 20) % 3 == 1
    echogram["Data"].values[:, lost] = np.nan
    return echogram, layers


def border_cases(stream):
    """Name, planted flight, frames, and zone edges where they are given, of every case."""
    default = Planted()
    frames = list(default.frames(stream(PANEL, "default")))

    def own(name, planted):
        return name, planted, list(planted.frames(stream(PANEL, name))), None

    def cut(**selection):
        return [tuple(part.isel(**selection) for part in frame) for frame in frames]

    def cut_rows(rows):
        return [(echogram.isel(twtt=rows), layers) for echogram, layers in frames]

    buried, deepest = slice(1, None), len(default.peak_power) - 1
    return [
        ("as planted", default, frames, None),
        ("no layers", default, _picks(frames, _without(slice(None))), None),
        ("surface alone", default, _picks(frames, _without(buried)), None),
        own("one slab", replace(default, peak_power=default.peak_power[:2], decay_rate=default.decay_rate[:2])),
        own("one zone: level slabs", replace(default, thickness_sd=0.0)),
        ("zones without data", default, frames, [10.0, 20, 30, 40, 90]),
        ("less than a block", default, cut(slow_time=slice(0, 255)), None),
        ("layer in 4 groups", default, _picks(frames, _without(deepest, slice(20, None))), None),
        ("layer in no whole block", default, _picks(frames, _without(deepest, slice(120, 130))), None),
        ("gaps in every block", default, _picks(frames, _without(buried, slice(100, 110))), None),
        ("layer never picked", default, _picks(frames, _without(2)), None),
        ("surface not picked in a frame", default, _picks(frames, _without(0, first_frame=3)), None),
        ("first slab picked in one frame", default, _picks(frames, _without(1, first_frame=1)), None),
        ("picks below the record", default, cut_rows(slice(0, 200)), None),
        ("no air above the surface", default, cut_rows(slice(30, None)), None),
        ("a third of the lines lost", default, [_lost_lines(frame) for frame in frames], None),
        own("no speckle", replace(default, n_looks=np.inf)),
        ("layers cross", default, _picks(frames, _crossed), None),
    ]


def draw_atlas(stream, *, share=1.0):
    """Rows of all panels as a table with `COLUMNS`; `stream` and `share` as for `sweep`, borders are always run."""
    rows = [row for panel in SWEEPS for row in sweep(panel, stream, share=share)]
    for name, planted, frames, edges in border_cases(stream):
        for estimator in ESTIMATORS:
            rows += judged(PANEL, name, planted, frames, estimator, zone_edge_bins=edges)
    return pd.DataFrame(rows, columns=list(COLUMNS))
