"""Values that label sets read from flight statistics, each checked as it is read."""

import numpy as np
import pandas as pd

from snowsim.echogram import check_choice
from snowsim.limits import check_values


def values_of(statistics, name, dims):
    """A variable or coordinate of the statistics on `dims`, float; ValueError if not finite."""
    values = np.empty(0)
    if name in statistics:
        values = statistics[name].transpose(*dims).values.astype(float)
    if values.size == 0 or not np.isfinite(values).all():
        held = ", ".join(map(str, statistics.variables))
        msg = f"flight statistics need {name}, all finite, got shape {values.shape}; hold {held}"
        raise ValueError(msg)
    return values


def of_uppermost(statistics, name, n_layers):
    """Positive values of the uppermost layers, (layer,).

    A layer without one, or below the flight's last, takes that of the nearest layer above.
    """
    check_choice("a flight statistic", name, list(map(str, statistics.variables)))
    values = statistics[name].values.astype(float)
    check_values(f"flight statistics: {name} at layer 0", values[0], 0, above=True)
    usable = np.isfinite(values) & (values > 0)
    nearest_above = pd.Series(values).where(usable).ffill()
    return nearest_above.reindex(range(n_layers), method="ffill").to_numpy()


def radar_of(statistics):
    """Number of looks and correlation of speckle, as arguments of `Echoes`.

    The correlation is measured in air above the surface; statistics of images hold none.
    """
    radar = {"n_looks": float(statistics.attrs["n_looks"])}
    if "speckle_correlation" in statistics:
        radar["speckle_correlation"] = statistics["speckle_correlation"].values
    return radar
