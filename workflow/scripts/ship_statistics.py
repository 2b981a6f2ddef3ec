"""Statistics of the reference flight in the form in which they come with the package."""

from job import run

from lib.shipped import shipped
from snowsim.io.files import read_dataset, write_dataset


def ship(statistics, data):
    write_dataset(data, shipped(read_dataset(statistics)), compress=True)


run(ship)
