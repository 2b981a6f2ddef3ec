"""Eq. (1) for one layer by its textbook form, with enough digits to survive it."""

import mpmath


def waveform_in_80_digits(x_bins, variance_bins2, decay_rate):
    with mpmath.workdps(80):
        x, d, a = (mpmath.mpf(float(value)) for value in (x_bins, variance_bins2, decay_rate))
        z = (a * d - x) / mpmath.sqrt(2 * d)
        return mpmath.sqrt(mpmath.pi * d / 2) * mpmath.exp(a * a * d / 2 - a * x) * mpmath.erfc(z)
