"""Families and numbers of zones: the planted one is found, what is saved is counted."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal

from lib.diagnostics.label_models import (
    choose,
    compare_models,
    tabulate_criteria,
    tabulate_families,
    whittle_log_likelihood,
)
from snowsim.labels import prepare
from snowsim.labels.models import FAMILIES, MODELS, fit_family, label_model
from snowsim.statistics.blocks import periodogram

N_LINES = 256
WAVENUMBER = np.fft.rfftfreq(N_LINES)
TRUTH = {
    "white": (3.0,),
    "power_law": (2e-4, 2.3),
    "ar1": (0.02, 0.95),
    "matern": (5e-5, np.log(0.03), 1.6),
}


def density_of(name):
    """Density of the planted parameters, written out by hand."""
    k = np.where(WAVENUMBER > 0, WAVENUMBER, np.inf)
    a, *shape = TRUTH[name]
    if name == "white":
        density = np.full(k.size, a)
    elif name == "power_law":
        density = a / k ** shape[0]
    elif name == "ar1":
        density = a / (1 + shape[0] ** 2 - 2 * shape[0] * np.cos(2 * np.pi * WAVENUMBER))
    else:
        density = a / (np.exp(shape[0]) ** 2 + WAVENUMBER**2) ** shape[1]
    density[0] = 0
    density[-1] /= 2
    return density


def zone_model(name, n_zones, n_blocks, rng, true_zones=2, n_slabs=3):
    """A flight whose slabs have spectra of one family, level and scale by true zone, divided into some zones."""
    unit = density_of(name)[1:-1]
    blocks = rng.exponential(unit, (true_zones, n_blocks, n_slabs, unit.size)) * np.array([1.0, 9])[:, None, None, None]
    shares = np.array([0.6, 1.0])[:, None, None] + 0.02 * rng.standard_normal((true_zones, n_blocks, n_slabs))
    blocks, shares = (part.reshape(n_zones, -1, *part.shape[2:]) for part in (blocks, shares))
    n = np.full((n_zones, n_slabs), shares.shape[1])
    psd = np.pad(blocks.mean(axis=1), [(0, 0), (0, 0), (1, 1)])
    variance = shares.var(axis=1, ddof=1)[:, 1:]
    likelihood = -0.5 * (n[:, 1:] * (np.log(2 * np.pi * variance) + 1)).sum()
    cells = ("zone", "slab")
    return xr.Dataset(
        {
            "thickness_psd": ((*cells, "wavenumber"), psd),
            "block_psd": ((*cells, "wavenumber"), psd),
            "n_psd_samples": (cells, n),
            "psd_source": (cells, np.zeros_like(n)),
        },
        attrs={
            "dispersion": 1.0,
            "means_log_likelihood": likelihood,
            "means_n_parameters": 2 * variance.size,
            "means_aic_penalty": 4.0 * variance.size,
            "means_bic_penalty": 2 * variance.size * np.log(n[0, 0]),
        },
    )


@pytest.mark.parametrize("name", FAMILIES)
def test_a_family_fits_its_own_spectrum(name):
    density, parameters = fit_family(name, density_of(name))
    # The search ends where the likelihood is flat to 1e-9: densities to its root, parameters alike.
    assert_allclose(density[1:], density_of(name)[1:], rtol=3e-3)
    assert_allclose(parameters[1:], TRUTH[name][1:], rtol=1e-2)


@pytest.mark.parametrize("name", FAMILIES)
def test_a_fitted_family_is_the_most_likely_of_its_kind(name, rng):
    observed = density_of(name) * rng.gamma(20, 1 / 20, WAVENUMBER.size)
    density, parameters = fit_family(name, observed)
    best = whittle_log_likelihood(observed[None], density[None], np.array([20]))
    for factor in (0.97, 1.03):
        assert whittle_log_likelihood(observed[None], factor * density[None], np.array([20])) < best
    # As likely as the truth or more, and more by half its parameters on average.
    truth = whittle_log_likelihood(observed[None], density_of(name)[None], np.array([20]))
    assert best >= truth - 1e-6 * abs(truth)
    assert best - truth < 12
    assert parameters.size == FAMILIES[name].n_parameters


@pytest.mark.parametrize("name", FAMILIES)
def test_bic_finds_the_planted_family_and_number_of_zones(name, rng):
    seed = int(rng.integers(1 << 30))  # one flight, divided three ways
    models = [zone_model(name, n_zones, 40, np.random.default_rng(seed)) for n_zones in (1, 2, 4)]
    table = tabulate_criteria(models)
    assert choose(table, 2, "bic") == (2, name)
    assert choose(table, "bic", name) == (2, name)
    rows = table.set_index(["n_zones", "psd"])
    # A density a wavenumber and slab of each zone against a few numbers.
    assert rows.loc[(2, "tabulated"), "n_parameters"] == 2 * 3 * 127 + 8
    assert rows.loc[(2, name), "n_parameters"] == 2 * 3 * FAMILIES[name].n_parameters + 8


def test_a_spectrum_of_no_family_stays_tabulated(rng):
    lumpy = zone_model("white", 2, 400, rng)
    comb = 1 + 0.9 * np.cos(40 * np.pi * WAVENUMBER)
    for part in ("thickness_psd", "block_psd"):
        lumpy[part] = lumpy[part] * comb
    table = tabulate_criteria([lumpy])
    assert choose(table, "aic", "aic")[1] == choose(table, "bic", "bic")[1] == "tabulated"


def test_penalty_of_a_tabulated_density_is_its_optimism(rng):
    n, trials = 8, 4000
    seen, new = rng.exponential(1, (2, trials, n, 127)).mean(axis=2)
    pad = [(0, 0), (1, 1)]
    in_sample = whittle_log_likelihood(np.pad(seen, pad), np.pad(seen, pad), np.full(trials, n)) / trials
    out_of_sample = whittle_log_likelihood(np.pad(new, pad), np.pad(seen, pad), np.full(trials, n)) / trials
    # 508,000 ratios whose variance is some 20: to 0.5 % of the 145 of n / (n - 1) a wavenumber, four of those.
    assert_allclose(in_sample - out_of_sample, 127 * n / (n - 1), rtol=0.03)


def test_choice_is_refused_where_it_is_none():
    table = pd.DataFrame({"n_zones": [4], "psd": ["tabulated"], "aic": [0.0], "bic": [0.0]})
    assert choose(table, 4, "tabulated") == (4, "tabulated")
    with pytest.raises(ValueError, match="one criterion, got aic and bic"):
        choose(table, "aic", "bic")
    with pytest.raises(ValueError, match="hold no 7 zones"):
        choose(table, 7, "tabulated")
    with pytest.raises(ValueError, match="psd must be one of white, power_law, ar1, matern, got 'cubic'"):
        fit_family("cubic", np.ones(129))


def test_a_label_model_keeps_variance_and_draws(rng):
    from planted_labels import planted

    statistics = planted(n_slabs=6)
    power = {}
    for psd in MODELS:
        model = label_model(statistics, psd)
        assert_array_equal(model["thickness_psd_tabulated"], statistics["thickness_psd"])
        power[psd] = model["thickness_psd"].values.sum(axis=2)
    # The planted spectrum is a Matern of exponent 1 with corner at 0.01.
    assert_allclose(power["matern"], power["tabulated"], rtol=0.01)
    counts = dict(zip(MODELS, (9, 1, 2, 2, 3), strict=True))
    criteria = pd.DataFrame([{"n_zones": 4, "psd": psd, "n_parameters": n} for psd, n in counts.items()])
    criteria = criteria.assign(aic=0.0, bic=0.0)
    shown = ("tabulated", "matern", "white")
    models = {psd: (4, psd, prepare(label_model(statistics, psd), N_LINES)) for psd in shown}
    table = compare_models(models, criteria, 60, lambda: np.random.default_rng(3)).set_index("model")
    assert (table.loc["tabulated"].filter(like="_change") == 0).all()
    assert_allclose(table.loc["matern", "parameters_saved"], 2 / 3)
    # The same random numbers through nearly the same spectrum; white noise of its variance lies in the last band.
    assert np.abs(table.loc["matern"].filter(like="_change").astype(float)).max() < 0.02
    assert table.loc["white", "undulation_3_bins"] > 3 * table.loc["tabulated", "undulation_3_bins"]


def test_families_are_tabulated_by_zone():
    table = tabulate_families(np.array([density_of("ar1"), 4 * density_of("ar1")]))
    assert list(table.columns) == ["zone", "wavenumber", "tabulated", *FAMILIES]
    assert_allclose(table["ar1"], table["tabulated"], rtol=3e-3)


def test_periodograms_of_an_autoregression_are_those_of_its_family(rng):
    r, n_blocks = 0.8, 400
    series = np.zeros((n_blocks, 600))
    noise = rng.standard_normal(series.shape)
    for line in range(1, 600):
        series[:, line] = r * series[:, line - 1] + noise[:, line]
    _, (scale, shape) = fit_family("ar1", periodogram(series[:, -N_LINES:]).mean(axis=0))
    # 400 blocks of 256 lines: r to sqrt((1 - r^2) / 102400) = 0.002, the scale to 0.6 %; leakage adds 1 / 256 of it.
    assert abs(shape - r) < 0.01
    assert_allclose(scale, 2, rtol=0.04)
