"""Label models compared: the planted law and number of zones are found."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from planted_labels import WAVENUMBER, density_of, paper_model, planted

from evaluation.lib import label_models
from evaluation.lib.label_models import (
    choose,
    compare_models,
    tabulate_models,
    whittle_log_likelihood,
)
from evaluation.lib.spectra import SPECTRA, with_spectra


def zone_model(name, n_zones, n_blocks, rng):
    """A flight of 3 slabs and 2 true zones with spectra of one law, divided into some zones."""
    unit = density_of(name)[1:-1]
    blocks = (
        rng.exponential(unit, (2, n_blocks, 3, unit.size)) * np.array([1.0, 9])[:, None, None, None]
    )
    shares = np.array([0.6, 1.0])[:, None, None] + 0.02 * rng.standard_normal((2, n_blocks, 3))
    blocks, shares = (part.reshape(n_zones, -1, *part.shape[2:]) for part in (blocks, shares))
    n = np.full((n_zones, 3), shares.shape[1])
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


@pytest.mark.parametrize("name", SPECTRA)
def test_bic_finds_the_planted_law_and_number_of_zones(name, rng):
    seed = int(rng.integers(1 << 30))  # one flight, divided three ways
    models = [zone_model(name, n_zones, 40, np.random.default_rng(seed)) for n_zones in (1, 2, 4)]
    table = tabulate_models(models)
    assert choose(table, 2, "bic") == (2, name)
    assert choose(table, "bic", name) == (2, name)
    rows = table.set_index(["n_zones", "psd"])
    # A density a wavenumber and slab of each zone against a few numbers.
    assert rows.loc[(2, "tabulated"), "n_parameters"] == 2 * 3 * 127 + 8
    assert rows.loc[(2, name), "n_parameters"] == 2 * 3 * SPECTRA[name].n_parameters + 8


def test_a_spectrum_of_no_law_stays_tabulated(rng):
    lumpy = zone_model("white", 2, 400, rng)
    comb = 1 + 0.9 * np.cos(40 * np.pi * WAVENUMBER)
    for part in ("thickness_psd", "block_psd"):
        lumpy[part] = lumpy[part] * comb
    table = tabulate_models([lumpy])
    assert choose(table, "aic", "aic")[1] == choose(table, "bic", "bic")[1] == "tabulated"


def test_penalty_of_a_tabulated_density_is_its_optimism(rng):
    n, trials = 8, 4000
    seen, new = rng.exponential(1, (2, trials, n, 127)).mean(axis=2)
    pad = [(0, 0), (1, 1)]
    in_sample = (
        whittle_log_likelihood(np.pad(seen, pad), np.pad(seen, pad), np.full(trials, n)) / trials
    )
    out_of_sample = (
        whittle_log_likelihood(np.pad(new, pad), np.pad(seen, pad), np.full(trials, n)) / trials
    )
    # 508,000 ratios whose variance is some 20: to 0.5 % of the 145 of n / (n - 1) a wavenumber,
    # four of those.
    assert_allclose(in_sample - out_of_sample, 127 * n / (n - 1), rtol=0.03)


def test_choice_is_refused_where_it_is_none_and_spectra_are_tabulated_by_zone():
    table = pd.DataFrame({"n_zones": [4], "psd": ["tabulated"], "aic": [0.0], "bic": [0.0]})
    assert choose(table, 4, "tabulated") == (4, "tabulated")
    with pytest.raises(ValueError, match="one criterion, got aic and bic"):
        choose(table, "aic", "bic")
    with pytest.raises(ValueError, match="hold no 7 zones"):
        choose(table, 7, "tabulated")
    table = label_models.tabulate_spectra(np.array([density_of("ar1"), 4 * density_of("ar1")]))
    assert list(table.columns) == ["zone", "wavenumber", "tabulated", *SPECTRA]
    assert_allclose(table["ar1"], table["tabulated"], rtol=3e-3)


def test_what_a_model_costs_stands_beside_the_first():
    statistics = planted(n_slabs=6)
    n_parameters = {"tabulated": 9, "matern": 3, "white": 1}
    selection = pd.DataFrame(
        {"n_zones": 4, "psd": list(n_parameters), "n_parameters": list(n_parameters.values())}
    )
    models = {psd: (4, psd, paper_model(with_spectra(statistics, psd))) for psd in n_parameters}
    table = compare_models(
        models, selection.assign(aic=0.0, bic=0.0), 60, lambda: np.random.default_rng(3)
    ).set_index("model")
    assert (table.loc["tabulated"].filter(like="_change") == 0).all()
    assert_allclose(table.loc["matern", "parameters_saved"], 2 / 3)
    # The same random numbers through nearly the same spectrum; white noise of its variance lies in
    # the last band.
    assert np.abs(table.loc["matern"].filter(like="_change").astype(float)).max() < 0.02
    assert table.loc["white", "undulation_3_bins"] > 3 * table.loc["tabulated", "undulation_3_bins"]
