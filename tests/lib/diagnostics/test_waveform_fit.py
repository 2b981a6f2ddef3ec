"""Best fit of eq. (1) to a given echo."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from lib.diagnostics.phy_errors import fit_waveform
from snowsim.phy.waveform import waveform_exact

X_BINS = np.arange(-20, 150, 0.25)


@pytest.mark.parametrize(("variance", "decay"), [(12.0, 0.05), (2.0, 0.09), (0.5, 0.2)])
def test_a_waveform_of_eq_1_is_found_again(variance, decay):
    fit = fit_waveform(X_BINS, 0.3 * waveform_exact(X_BINS - 4.0, variance, decay), 20.0)
    # Least squares stop at 1e-12 of the cost; the parameters' errors are its square root.
    assert fit.rms_db < 1e-4
    assert_allclose([fit.variance_bins2, fit.decay_rate, fit.amplitude], [variance, decay, 0.3], rtol=1e-3)
    assert_allclose(fit.offset_bins, 4.0, atol=1e-3)
    assert_allclose(fit.power(30.0), 0.3 * waveform_exact(26.0, variance, decay), rtol=1e-4)


def test_two_decays_are_no_waveform_of_eq_1_and_the_error_says_by_how_much():
    x = np.arange(0, 200, 0.5)
    level_db = np.where(x < 50, -0.2 * x, -10 - 0.1 * (x - 50))
    fit = fit_waveform(x, 10 ** (level_db / 10), 20.0)
    # Beyond its Gaussian eq. (1) is a straight line in decibels: the best line is what it can do, and hardly more.
    line = np.polyval(np.polyfit(x[:300], level_db[:300], 1), x[:300])
    assert_allclose(fit.rms_db, np.sqrt(np.mean((line - level_db[:300]) ** 2)), rtol=0.05)
    assert fit.largest_db > fit.rms_db
    error_db = 10 * np.log10(fit.power(x[:300])) - level_db[:300]
    assert_allclose(np.sqrt(np.mean(error_db**2)), fit.rms_db, rtol=0.02)
    assert_allclose(fit.n_bins, 150, atol=1)


@pytest.mark.parametrize(
    ("power", "message"),
    [
        (np.ones(10), "has no end"),
        (np.array([1.0, 0.5, *[0.0] * 8]), "six samples"),
        (np.array([1.0, -0.5, *[0.0] * 8]), "not negative"),
        (np.ones(4), "shapes"),
    ],
)
def test_what_has_no_tail_is_refused(power, message):
    with pytest.raises(ValueError, match=message):
        fit_waveform(np.arange(10), power, 20.0)
