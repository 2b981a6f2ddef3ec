import mpmath
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from snowsim.phy.waveform import waveform_exact, waveform_peak, waveform_width

SMALLEST_NORMAL = np.finfo(float).tiny


def waveform_in_80_digits(x_bins, variance_bins2, decay_rate):
    """Eq. (1) for one layer by its textbook form, with enough digits to survive it."""
    with mpmath.workdps(80):
        x, d, a = (mpmath.mpf(float(each)) for each in (x_bins, variance_bins2, decay_rate))
        z = (a * d - x) / mpmath.sqrt(2 * d)
        area = mpmath.sqrt(mpmath.pi * d / 2)
        decay = mpmath.exp(a * a * d / 2 - a * x)
        return area * decay * mpmath.erfc(z)


def log_uniform(low, high):
    return st.floats(np.log10(low), np.log10(high)).map(lambda exponent: 10.0**exponent)


@settings(max_examples=300, deadline=None)
@given(
    decay_rate=log_uniform(1e-4, 10),
    variance_bins2=log_uniform(1e-2, 1e4),
    x_bins=st.floats(-1e3, 1e4),
    deviations=st.floats(-8, 8),
)
# A Gaussian much wider than the exponential, and one so narrow that it leaves an exponential.
@example(decay_rate=10.0, variance_bins2=100.0, x_bins=0.0, deviations=0.0)
@example(decay_rate=0.1, variance_bins2=1e-6, x_bins=100.0, deviations=0.0)
def test_waveform_agrees_with_80_digits(decay_rate, variance_bins2, x_bins, deviations):
    near_centre = deviations * np.sqrt(variance_bins2)
    near_change_of_branch = near_centre + decay_rate * variance_bins2
    for at in (x_bins, near_centre, near_change_of_branch):
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            waveform = waveform_exact(at, variance_bins2, decay_rate)
        expected = waveform_in_80_digits(at, variance_bins2, decay_rate)
        if expected < SMALLEST_NORMAL:
            # Underflows to zero, or to a number that no longer has 53 bits.
            assert 0 <= waveform <= 1.01 * SMALLEST_NORMAL
        else:
            # An exponent of at most 745 is known to 3 eps of itself: 5e-13.
            assert abs(waveform / expected - 1) < 1e-12


@pytest.mark.parametrize("decay_rate", [1e-12, 1e-4, 0.05, 0.07, 0.09, 10, 1e6])
@pytest.mark.parametrize("variance_bins2", [1e-12, 1e-2, 12, 1e4, 1e12])
def test_peak_is_where_the_waveform_is_highest_and_width_where_it_has_fallen_to_1_over_e(
    variance_bins2, decay_rate
):
    offset_bins, value = waveform_peak(variance_bins2, decay_rate)
    deviation = np.sqrt(variance_bins2)
    near = offset_bins + np.array([-0.01, 0, 0.01]) * deviation
    around = waveform_exact(near, variance_bins2, decay_rate)
    assert_allclose(around[1], value, rtol=1e-12)
    # Slow decays leave a peak flat to the last place.
    assert around[[0, 2]].max() <= around[1] * (1 + 1e-15)
    width_bins = waveform_width(variance_bins2, decay_rate)
    fallen = waveform_exact(offset_bins + width_bins, variance_bins2, decay_rate)
    # Where decay times deviation passes 1e6 the width is that of its limit, good to 1e-12.
    assert_allclose(fallen, value / np.e, rtol=4e-12)
    assert width_bins > 0
