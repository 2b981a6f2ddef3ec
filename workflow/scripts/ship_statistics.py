"""Statistics of the reference flight in the form in which they come with the package."""

import numpy as np
from job import run

from snowsim.io.files import read_dataset, write_dataset


def shipped(statistics):
    """The same in float32 but for coordinates: rounding is 1e-4 of the standard errors or less."""
    doubles = [name for name, values in statistics.data_vars.items() if values.dtype == np.float64]
    return statistics.assign({name: statistics[name].astype(np.float32) for name in doubles})


def ship(statistics, data):
    write_dataset(data, shipped(read_dataset(statistics)), compress=True)


run(ship)
