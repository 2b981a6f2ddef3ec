"""Statistics of the reference flight in the form in which they come with the package."""

import numpy as np
from job import job

from snowsim.io.files import read_dataset, write_dataset

with job(snakemake):
    statistics = read_dataset(snakemake.input.statistics)
    # In float32, but for coordinates: rounding is 6e-8 of a value.
    doubles = [name for name, values in statistics.data_vars.items() if values.dtype == np.float64]
    shipped = statistics.assign({name: statistics[name].astype(np.float32) for name in doubles})
    write_dataset(snakemake.output.data, shipped, compress=True)
