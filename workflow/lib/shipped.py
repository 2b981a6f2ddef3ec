"""What comes with the package of a run of the default configuration."""

import numpy as np


def shipped(statistics):
    """Flight statistics with float32 variables: their standard errors are 1e4 times its rounding or more.

    Coordinates keep their type; so do values that float32 cannot hold.
    """
    small = {
        name: values.astype(np.float32)
        for name, values in statistics.data_vars.items()
        if values.dtype == np.float64 and not np.any(_lost(values.values))
    }
    return statistics.assign(small)


def _lost(values):
    """Where float32 overflows, or underflows to fewer digits."""
    limits = np.finfo(np.float32)
    size = np.abs(values[np.isfinite(values) & (values != 0)])
    return (size < limits.tiny) | (size > limits.max)
