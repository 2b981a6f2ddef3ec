"""Eq. (1) for one layer by its textbook form, with enough digits to survive it."""

import mpmath


def waveform_in_80_digits(x_bins, variance_bins2, decay_rate):
    with mpmath.workdps(80):
        x = mpmath.mpf(float(x_bins))
        d = mpmath.mpf(float(variance_bins2))
        a = mpmath.mpf(float(decay_rate))
        z = (a * d - x) / mpmath.sqrt(2 * d)
        area = mpmath.sqrt(mpmath.pi * d / 2)
        decay = mpmath.exp(a * a * d / 2 - a * x)
        return area * decay * mpmath.erfc(z)
