"""Echoes that are no layers: crusts between them, and bands of coherent noise.

Statistics hold neither, as nobody picks them. A network that is to leave them out must see them.
"""

import dataclasses
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter1d

from snowsim.echogram import Kind

# A crust lies so far down its slab, as a share of it; thinner slabs have none.
WITHIN_SLAB = (0.15, 0.85)
THINNEST_BINS = 8.0
# How powers of crusts vary from one to the next, and along track [dB]; lengths in range lines.
CRUST_SPREAD_DB = 4.0
FADING_DB = 3.0
CRUST_LENGTH_LINES = (10.0, 100.0)
# Standard deviations of a band's shape, and of its row along track: the surface is levelled, the
# band is not.
BAND_WIDTH_BINS = (1.0, 3.0)
WANDER_BINS = (0.0, 4.0)
WANDER_LENGTH_LINES = 40.0


@dataclass(frozen=True)
class Clutter:
    """How much of it a climate and a radar show.

    Attributes
    ----------
    crusts_per_slab : float
        Mean number of crusts between two layers.
    crust_db : float
        Their median power, relative to the layer below [dB].
    bands_per_100_bins : float
        Mean number of bands.
    band_db : float
        Their mean power, relative to the noise [dB]; it is exponentially distributed.
    """

    crusts_per_slab: float = 0.0
    crust_db: float = 0.0
    bands_per_100_bins: float = 0.0
    band_db: float = 0.0


def with_crusts(echoes, clutter, *, rng):
    """`Echoes` with crusts between layers, labelled or not; they follow the layers about them."""
    n_lines = echoes.bins.shape[1]
    layers = np.flatnonzero(echoes.kind != Kind.BACKGROUND)
    places = []
    rows = {"bins": [], "power": []}
    for above, below in pairwise(layers):
        slab = echoes.bins[below] - echoes.bins[above]
        slab = np.where(slab < THINNEST_BINS, np.nan, slab)
        n_crusts = rng.poisson(clutter.crusts_per_slab)
        for share in np.sort(rng.uniform(*WITHIN_SLAB, n_crusts)):
            db = clutter.crust_db + CRUST_SPREAD_DB * rng.standard_normal()
            db = db + FADING_DB * _smooth(n_lines, rng.uniform(*CRUST_LENGTH_LINES), rng=rng)
            places.append(below)
            rows["bins"].append(echoes.bins[above] + share * slab)
            rows["power"].append(echoes.power[below] * 10 ** (db / 10))
    if not places:
        return echoes
    inserted = {
        name: np.insert(getattr(echoes, name), places, np.array(values), axis=0)
        for name, values in rows.items()
    }
    for name in ("variance_bins2", "decay_rate"):
        values = getattr(echoes, name)
        inserted[name] = np.insert(values, places, values[places])
    inserted["kind"] = np.insert(echoes.kind, places, np.int8(Kind.BACKGROUND))
    return dataclasses.replace(echoes, **inserted)


def bands(shape, noise_power, clutter, *, rng):
    """Power of horizontal bands of coherent noise, linear, of `shape` (range_bin, range_line)."""
    n_range_bins, n_lines = shape
    power = np.zeros(shape)
    row = np.arange(n_range_bins)[:, None]
    wander = rng.uniform(*WANDER_BINS) * _smooth(n_lines, WANDER_LENGTH_LINES, rng=rng)
    mean_power = noise_power * 10 ** (clutter.band_db / 10)
    for _ in range(rng.poisson(clutter.bands_per_100_bins * n_range_bins / 100)):
        away = row - rng.uniform(0, n_range_bins) - wander
        width = rng.uniform(*BAND_WIDTH_BINS)
        power += mean_power * rng.exponential() * np.exp(-(away**2) / (2 * width**2))
    return power


def _smooth(n, length, *, rng):
    """Gaussian noise, smooth over `length`, of unit variance where `n` is far above it, (n,)."""
    noise = gaussian_filter1d(rng.standard_normal(n), length, mode="wrap")
    return noise * np.sqrt(2 * np.sqrt(np.pi) * length)
