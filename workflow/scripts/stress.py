"""The stability atlases of PHY and of the estimators as tables, and the safe region of every method of PHY."""

from job import logger, run

from lib.diagnostics import phy_atlas, statistics_atlas
from snowsim.io.files import write_table
from snowsim.seeding import random_stream


def stress(phy, phy_regions, statistics, *, seed, share):
    atlas = phy_atlas.draw_atlas(rng=random_stream(seed, "stress_phy"))
    public = atlas[atlas["method"].isin(phy_atlas.PUBLIC)]
    logger.info("%d of %d outcomes of public functions are wrong", (public["outcome"] == "wrong").sum(), len(public))
    write_table(phy, atlas)
    write_table(phy_regions, phy_atlas.safe_regions(atlas))
    sweeps = statistics_atlas.draw_atlas(lambda *keys: random_stream(seed, "stress_statistics", *keys), share=share)
    logger.info("outcomes of estimators: %s", sweeps["outcome"].value_counts().to_dict())
    write_table(statistics, sweeps)


run(stress)
