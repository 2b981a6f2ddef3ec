"""What labels read of flight statistics, checked."""

import numpy as np


def values_of(statistics, name, dims):
    """A variable or coordinate of the statistics as float array on `dims`, finite."""
    if name not in statistics:
        msg = f"flight statistics need {name}, hold {', '.join(map(str, statistics.variables))}"
        raise ValueError(msg)
    values = statistics[name].transpose(*dims).values.astype(float)
    if values.size == 0 or not np.isfinite(values).all():
        msg = f"flight statistics: {name} must be finite and not empty, got shape {values.shape} with NaN or infinity"
        raise ValueError(msg)
    return values
