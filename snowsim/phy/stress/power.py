"""Sweeps of mean power: each pushes one property of a scene to where methods fail."""

from dataclasses import replace

import numpy as np

from snowsim.phy.stress.judge import Case, judged, noisy

LINES = np.array([[0.0, 0.26, 0.53, 0.77]])  # sub-bin positions
SHORTCUTS = ("naive", "sampled", "wrapped", "cut", "nearest", "recursive32")
# One layer, peaking at 6.7 with noise of 1e-3 under it.
PLAIN = Case(100 + LINES, np.ones(1), np.full(1, 12.0), np.full(1, 0.07))


def _pair(spacing_bins, **changes):
    """Two plain layers."""
    both = {name: np.repeat(getattr(PLAIN, name), 2) for name in ("peak_power", "variance_bins2", "decay_rate")}
    layer_bins = np.concatenate([PLAIN.layer_bins, PLAIN.layer_bins + spacing_bins])
    return replace(PLAIN, layer_bins=layer_bins, **(both | changes))


def sweep_decay():
    """Decay rate: exponentials that outlast the window, and ones shorter than a bin."""
    values = 10.0 ** np.arange(-6, 4.1, 0.5)
    cases = [(value, noisy(replace(PLAIN, decay_rate=np.array([value])))) for value in values]
    return judged("decay rate [per bin]", cases, SHORTCUTS)


def sweep_variance():
    """Width of the Gaussian: far narrower than a bin, and far wider than the window."""
    values = 10.0 ** np.arange(-6, 8.1, 0.5)
    cases = [(value, noisy(replace(PLAIN, variance_bins2=np.array([value])))) for value in values]
    return judged("variance [bins²]", cases, (*SHORTCUTS, "recursive64"))


def sweep_position():
    """Position: across the borders of the window of 256 bins, on them, and far outside."""
    inside = [-1, 0, 10, 50, 128, 200, 240, 250, 254, 255, 256, 260, 300]
    values = [*-(10.0 ** np.arange(4, 0.9, -0.5)), *inside, 1e3, 1e4]
    return judged("position [bins]", [(value, replace(PLAIN, layer_bins=value + LINES)) for value in values], SHORTCUTS)


def sweep_spacing():
    """Distance of two layers: touching, and crossing, which is refused."""
    values = [-10, -1, -1e-3, 0, *10.0 ** np.arange(-15, 2.1)]
    cases = [(value, _pair(value)) for value in values]
    return judged("spacing of two layers [bins]", cases, ("naive", "sampled", "nearest", "recursive32"))


def sweep_power_ratio():
    """Dynamic range: the lower of two layers ever weaker, the noise 30 dB below it."""
    values = 10.0 ** np.array([-300, -250, -200, -150, -100, -50, *range(-30, 1, 2)])
    cases = [(value, noisy(_pair(60, peak_power=np.array([1, value])))) for value in values]
    return judged("power of the weaker layer", cases, ("naive", "sampled", "nearest", "recursive32", "table32"))


def sweep_tolerance():
    """Tolerance: from loose to below the resolution of float32, then of float64."""
    values = [10, 3, 1, *10.0 ** np.arange(-0.5, -15.1, -0.5)]
    cases = [(value, replace(PLAIN, tolerance_db=value)) for value in values]
    return judged("tolerance [dB]", cases, ("table32",))


def sweep_size():
    """Height of one column, from one pixel to a million, of a layer whose tail hardly decays."""
    values = [1, 2, 3, 10, 100, 1000, 10_000, 100_000, 1_000_000]
    cases = [
        (value, replace(PLAIN, layer_bins=np.array([[0.3 * value]]), decay_rate=np.array([1e-6]), n_range_bins=value))
        for value in values
    ]
    return judged("height [bins]", cases, ("wrapped", "cut", "recursive32", "recursive64"))
