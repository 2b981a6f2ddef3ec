import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from planted_labels import N_LINES, PARAMETERS, WAVENUMBER, density_of, planted

from evaluation.lib.label_models import whittle_log_likelihood
from evaluation.lib.spectra import MODELS, SPECTRA, fit_spectrum, with_spectra
from snowsim.statistics.blocks import periodogram


@pytest.mark.parametrize("name", SPECTRA)
def test_a_law_fits_its_own_spectrum(name):
    density, parameters = fit_spectrum(name, density_of(name))
    # The search ends where the likelihood is flat to 1e-9: densities to its root, parameters alike.
    assert_allclose(density[1:], density_of(name)[1:], rtol=3e-3)
    assert_allclose(parameters[1:], PARAMETERS[name][1:], rtol=1e-2)


@pytest.mark.parametrize("name", SPECTRA)
def test_a_fitted_law_is_the_most_likely_of_its_kind(name, rng):
    observed = density_of(name) * rng.gamma(20, 1 / 20, WAVENUMBER.size)
    density, parameters = fit_spectrum(name, observed)
    given = (density, 0.97 * density, 1.03 * density, density_of(name))
    best, less, more, truth = (
        whittle_log_likelihood(observed, each, np.array(20)) for each in given
    )
    assert best > max(less, more)
    # As likely as the truth or more, and more by half its parameters on average.
    assert best >= truth - 1e-6 * abs(truth)
    assert best - truth < 12
    assert parameters.size == SPECTRA[name].n_parameters


def test_periodograms_of_an_autoregression_are_those_of_its_law(rng):
    r, n_blocks = 0.8, 400
    series = np.zeros((n_blocks, 600))
    noise = rng.standard_normal(series.shape)
    for line in range(1, 600):
        series[:, line] = r * series[:, line - 1] + noise[:, line]
    _, (scale, shape) = fit_spectrum("ar1", periodogram(series[:, -N_LINES:]).mean(axis=0))
    # 400 blocks of 256 lines: r to sqrt((1 - r^2) / 102400) = 0.002, the scale to 0.6 %; leakage
    # adds 1 / 256 of it.
    assert abs(shape - r) < 0.01
    assert_allclose(scale, 2, rtol=0.04)


def test_an_unknown_law_is_refused():
    with pytest.raises(
        ValueError, match="psd must be one of white, power_law, ar1, matern, got 'cubic'"
    ):
        fit_spectrum("cubic", np.ones(129))


def test_a_label_model_keeps_the_variance_and_the_tabulated_spectrum():
    statistics = planted(n_slabs=6)
    models = {psd: with_spectra(statistics, psd) for psd in MODELS}
    assert_array_equal(models["tabulated"]["thickness_psd"], statistics["thickness_psd"])
    # The planted spectrum is a Matern of exponent 1 with corner at 0.01.
    power = {psd: models[psd]["thickness_psd"].sum("wavenumber") for psd in ("matern", "tabulated")}
    assert_allclose(power["matern"], power["tabulated"], rtol=0.01)
