"""The stability atlas of the estimators as a table."""

from job import job, logger

from lib.diagnostics.statistics_atlas import draw_atlas
from snowsim.io.files import write_table
from snowsim.seeding import random_stream


def stress(path_to_atlas, share, seed):
    atlas = draw_atlas(lambda *keys: random_stream(seed, "stress_statistics", *keys), share=share)
    logger.info("outcomes: %s", atlas["outcome"].value_counts().to_dict())
    write_table(path_to_atlas, atlas)


if __name__ == "__main__":
    with job(snakemake):
        stress(snakemake.output.atlas, **snakemake.params)
