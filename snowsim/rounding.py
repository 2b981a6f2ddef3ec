"""Numbers rounded to digits on which processors agree.

Sums of products, logarithms and powers end in other last bits on other kinds of x86-64 processor;
what follows from a number that a file keeps must not.
"""

import numpy as np


def rounded(values, n_bits):
    """Values with so many binary digits, float64 of the same shape; NaN and infinities stay.

    The relative error is at most 2^-`n_bits`: 1e-6 for 20, 1.5e-5 (7e-5 dB of power) for 16.
    """
    mantissa, exponent = np.frexp(np.asarray(values, dtype=float))
    return np.ldexp(np.rint(np.ldexp(mantissa, n_bits)), exponent - n_bits)


def on_grid(values, n_bits):
    """Values as multiples of 2^-`n_bits`, float64 of the same shape: 2.4e-4 for 12."""
    return np.ldexp(np.rint(np.ldexp(np.asarray(values, dtype=float), n_bits)), -n_bits)
