"""The atlases of PHY and of the estimators as tables, and where every method of PHY holds."""

from functools import partial

from main_path import logger, run

from evaluation.lib import phy_atlas, statistics_atlas
from snowsim.io.files import write_table
from snowsim.seeding import random_stream


def draw_atlases(phy, phy_regions, statistics, *, seed, share):
    atlas = phy_atlas.draw_atlas(rng=random_stream(seed, "stress_phy"))
    public = atlas[atlas["method"].isin(phy_atlas.PUBLIC)]
    n_wrong = (public["outcome"] == "wrong").sum()
    logger.info("%d of %d outcomes of public functions are wrong", n_wrong, len(public))
    write_table(phy, atlas)
    write_table(phy_regions, phy_atlas.summarise_atlas(atlas))
    stream = partial(random_stream, seed, "stress_statistics")
    sweeps = statistics_atlas.draw_atlas(stream, share=share)
    logger.info("outcomes of estimators: %s", sweeps["outcome"].value_counts().to_dict())
    write_table(statistics, sweeps)


run(draw_atlases)
