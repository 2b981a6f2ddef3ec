"""The stability atlas of PHY as tables: every sweep, and the safe region of every method."""

from job import job, logger

from lib.diagnostics.phy_atlas import PUBLIC, draw_atlas, safe_regions
from snowsim.io.files import write_table
from snowsim.seeding import random_stream


def stress(path_to_atlas, path_to_regions, seed):
    atlas = draw_atlas(rng=random_stream(seed, "stress_phy"))
    wrong = atlas[atlas["method"].isin(PUBLIC) & (atlas["outcome"] == "wrong")]
    logger.info("%d of %d outcomes of public functions are wrong", len(wrong), atlas["method"].isin(PUBLIC).sum())
    write_table(path_to_atlas, atlas)
    write_table(path_to_regions, safe_regions(atlas))


if __name__ == "__main__":
    with job(snakemake):
        stress(snakemake.output.atlas, snakemake.output.regions, **snakemake.params)
