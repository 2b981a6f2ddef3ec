"""Sweeps over what makes estimation hard: thin slabs, noise, speckle, short flights, gaps.

Flights at the borders of what can be fitted, and beyond: what degrades by which rule, what is refused.
The stability atlas of the estimators: planted flights pushed to where one or both lose what was planted.

A row has `panel, value, estimator, quantity`, mean `error` over layers against what was planted, its `largest`
magnitude, the mean `standard_error` claimed, `unit`, `bound`, the `outcome` and, as `note`, the rule that degraded the
result or the line that refused it. Outcomes: ``within`` the bound, ``beyond`` it, ``refused`` by a ValueError,
``not finite``, which must not be.
"""

from dataclasses import replace

import numpy as np
import pandas as pd

from lib.diagnostics.planted import Planted, judged
from snowsim.statistics.estimate import ESTIMATORS

GAP_LINES = 24  # mean length of a gap in a layer's picks [range lines]


def _spaced(value):
    return Planted(slab_bins=value)


def _noisy(value):
    weakest = min(Planted().peak_power)
    return Planted(noise_power=weakest * 10 ** (-value / 10))


def _speckled(value):
    return Planted(n_looks=value)


def _short(value):
    return Planted(n_frames=1, n_lines=int(value))


SWEEPS = {
    "slab thickness [bins]": ((3, 5, 8, 12, 18, 27, 44, 80), _spaced),
    "weakest layer over noise [dB]": ((-15, -10, -5, 0, 5, 10, 20, 30), _noisy),
    "looks of a range line": ((0.2, 0.5, 1, 2, 5, 20, 100), _speckled),
    "range lines of a flight": ((200, 256, 512, 1024, 2048, 4096), _short),
    "share of picks missing": ((0, 0.2, 0.4, 0.6, 0.8, 0.95), lambda _: Planted()),
}


def sweep(panel, stream, *, share=1.0):
    """Rows of one sweep: every value by every estimator, from the same flight.

    Parameters
    ----------
    panel : str
        Of `SWEEPS`.
    stream : callable
        Gives the random generator of a panel and a value.
    share : float
        Share of the values to run, spread evenly, both ends included.

    Returns
    -------
    list of dict
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


def few_layers(n):
    """The default flight with its first layers only."""
    planted = Planted()
    return replace(planted, peak_power=planted.peak_power[:n], decay_rate=planted.decay_rate[:n])


PANEL = "borders"


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
        own("one slab", few_layers(2)),
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


def sweep_borders(stream):
    """Rows of all border cases by every estimator."""
    return [
        row
        for name, planted, frames, edges in border_cases(stream)
        for estimator in ESTIMATORS
        for row in judged(PANEL, name, planted, frames, estimator, zone_edge_bins=edges)
    ]


COLUMNS = (
    *("panel", "value", "estimator", "quantity", "error", "largest", "standard_error"),
    *("unit", "bound", "outcome", "note"),
)


def draw_atlas(stream, *, share=1.0):
    """Rows of all panels as a table.

    Parameters
    ----------
    stream : callable
        Gives the random generator of a panel and a value on it.
    share : float
        Share of the values of each sweep to run, ends included; borders are always run.

    Returns
    -------
    pandas.DataFrame
        With `COLUMNS`.
    """
    rows = [row for panel in SWEEPS for row in sweep(panel, stream, share=share)]
    return pd.DataFrame([*rows, *sweep_borders(stream)], columns=list(COLUMNS))
