"""The atlases of PHY and of the estimators as tables."""

from functools import partial

from main_path import job

from evaluation.lib import atlas_phy, atlas_statistics
from snowsim.io.files import write_table
from snowsim.seeding import random_stream

with job(snakemake) as logger:
    seed = snakemake.params.seed
    of_phy = atlas_phy.draw_atlas(rng=random_stream(seed, "stress_phy"))
    logger.info("outcomes of PHY's methods: %s", of_phy["outcome"].value_counts().to_dict())
    write_table(snakemake.output.phy, of_phy)
    of_statistics = atlas_statistics.draw_atlas(partial(random_stream, seed, "stress_statistics"))
    logger.info("outcomes of estimators: %s", of_statistics["outcome"].value_counts().to_dict())
    write_table(snakemake.output.statistics, of_statistics)
