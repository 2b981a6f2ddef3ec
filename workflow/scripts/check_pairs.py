"""Read every scene of the lists before anything is computed from one; report all that fail."""

from job import run

from lib.sources import check_lists
from snowsim.io.files import write_table


def check_pairs(table, *, lists, data_scale, contrast_db):
    write_table(table, check_lists(lists, data_scale=data_scale, contrast_db=contrast_db))


run(check_pairs)
