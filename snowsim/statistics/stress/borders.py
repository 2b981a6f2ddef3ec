"""Flights at the borders of what can be fitted, and beyond: what degrades by which rule, what is refused."""

from dataclasses import replace

import numpy as np

from snowsim.statistics.estimate import ESTIMATORS
from snowsim.statistics.stress.planted import Planted, judged
from snowsim.statistics.stress.sweeps import few_layers

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
