"""Sweeps over what makes estimation hard: thin slabs, noise, speckle, short flights, gaps."""

from dataclasses import replace

import numpy as np

from snowsim.statistics.estimate import ESTIMATORS
from snowsim.statistics.stress.planted import Planted, judged

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
