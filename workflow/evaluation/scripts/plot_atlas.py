"""Atlases of PHY and of the estimators."""

from main_path import run

from evaluation.lib.figures import atlas
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_table


def plot_atlas(
    atlas_phy,
    atlas_statistics,
    atlas_phy_svg,
    atlas_statistics_svg,
    atlas_statistics_borders_svg,
    source,
):
    save_figure(atlas_phy_svg, atlas.atlas_phy(*map(read_table, atlas_phy)), source)
    save_figure(
        atlas_statistics_svg, atlas.atlas_statistics(*map(read_table, atlas_statistics)), source
    )
    save_figure(
        atlas_statistics_borders_svg,
        atlas.atlas_statistics_borders(*map(read_table, atlas_statistics)),
        source,
    )


run(plot_atlas)
