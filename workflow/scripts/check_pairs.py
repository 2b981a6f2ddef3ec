"""Read every scene of the lists before anything is computed from one; report all that fail."""

from job import job

from lib.sources import check_lists
from snowsim.io.files import write_table

with job(snakemake):
    checked = check_lists(
        snakemake.params.lists,
        contrast_db=snakemake.params.contrast_db,
        spacing=snakemake.params.spacing,
    )
    write_table(snakemake.output.table, checked)
