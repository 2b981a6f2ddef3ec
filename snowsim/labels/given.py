"""What label sets take from flight statistics, checked."""

import numpy as np


def values_of(statistics, name, dims):
    """A variable or coordinate of the statistics as float array on `dims`, finite."""
    if name not in statistics:
        msg = f"flight statistics need {name}, hold {', '.join(map(str, statistics.variables))}"
        raise ValueError(msg)
    values = statistics[name].transpose(*dims).values.astype(float)
    if values.size == 0 or not np.isfinite(values).all():
        msg = f"flight statistics: {name} must be finite and not empty, "
        msg += f"got shape {values.shape} with NaN or infinity"
        raise ValueError(msg)
    return values


def values_by_layer(statistics, name):
    """Positive values (layer,); a layer without one takes that of the nearest layer above."""
    values = statistics[name].values.astype(float)
    usable = np.isfinite(values) & (values > 0)
    if not (usable.size and usable[0]):
        msg = f"flight statistics: {name} must be positive and finite at layer 0, "
        msg += f"got {values[:1].tolist()}"
        raise ValueError(msg)
    nearest_above = np.maximum.accumulate(np.where(usable, np.arange(values.size), 0))
    return values[nearest_above]
