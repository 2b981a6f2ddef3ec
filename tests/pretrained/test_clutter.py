"""Crusts and bands: echoes that no one labels, where they lie and how strong they are."""

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from pretrained.clutter import Clutter, bands, with_crusts
from snowsim.echogram import Echoes, Kind

N_LINES = 400


def layered(thickness_bins=40.0, n_layers=30):
    """Level layers of power 2 with one row of background below the surface."""
    bins = 50 + thickness_bins * np.arange(n_layers)
    bins = np.insert(bins, 1, 50.5)
    kind = np.full(bins.size, Kind.LAYER, dtype=np.int8)
    kind[1] = Kind.BACKGROUND
    ones = np.ones((bins.size, N_LINES))
    variance = np.arange(bins.size, dtype=float)
    return Echoes(bins[:, None] * ones, 2 * ones, variance, variance / 10, kind, 1e-3, 16.0)


def test_crusts_lie_between_layers_in_the_number_and_power_that_are_asked_for(rng):
    echoes = layered(n_layers=60)
    found = with_crusts(echoes, Clutter(crusts_per_slab=4.0, crust_db=-10.0), rng=rng)
    assert (np.diff(found.bins, axis=0) > 0).all()
    for name in ("bins", "power", "variance_bins2", "decay_rate"):
        at_layers = found.kind == Kind.LAYER
        expected = getattr(echoes, name)[echoes.kind == Kind.LAYER]
        assert_array_equal(getattr(found, name)[at_layers], expected)
    crusts = np.flatnonzero(found.kind == Kind.BACKGROUND)[1:]
    # Poisson, of 59 slabs: four standard deviations.
    assert abs(crusts.size - 236) < 4 * np.sqrt(236)
    # A crust has the waveform of the layer below it.
    below = [np.flatnonzero(found.kind[crust:] == Kind.LAYER)[0] + crust for crust in crusts]
    assert_array_equal(found.decay_rate[crusts], found.decay_rate[below])
    relative_db = 10 * np.log10(found.power[crusts] / 2)
    # 236 crusts that differ by 5 dB: the standard error is 0.33 dB, allow four.
    assert_allclose(relative_db.mean(), -10, atol=1.3)
    assert_allclose(relative_db.std(), 5, rtol=0.15)


def test_thin_slabs_have_no_crusts_and_none_asked_for_changes_nothing(rng):
    thin = with_crusts(layered(7.0), Clutter(crusts_per_slab=3.0), rng=rng)
    assert np.isnan(thin.bins[thin.kind == Kind.BACKGROUND][1:]).all()
    echoes = layered()
    assert with_crusts(echoes, Clutter(), rng=rng) is echoes


def test_bands_have_the_mean_power_and_number_that_are_asked_for(rng):
    clutter = Clutter(bands_per_100_bins=1.0, band_db=3.0)
    drawn = [bands((600, 60), 1e-3, clutter, rng=rng) for _ in range(200)]
    # A band holds power times sqrt(2 pi) times its width, 1 to 3 bins; 6 in 600 bins. Their number
    # and power scatter by sqrt(2 / 1200) together, 4 %, those beyond the ends lose 1 %.
    expected = 6 * 2e-3 * np.sqrt(2 * np.pi) * 2 / 600
    assert_allclose(np.mean(drawn), expected, rtol=0.15)
    assert bands((600, 60), 1e-3, Clutter(), rng=rng).max() == 0


def test_bands_wander_along_track_together(rng):
    clutter = Clutter(bands_per_100_bins=0.6, band_db=3.0)
    power = bands((600, 256), 1e-3, clutter, rng=rng)
    steps = np.abs(np.diff(power.argmax(axis=0)))
    assert np.median(steps) <= 1
