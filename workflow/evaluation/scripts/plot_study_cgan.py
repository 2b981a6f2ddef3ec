"""Figures of the studies of the cGAN."""

from main_path import run

from evaluation.lib.figures import study_cgan
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_table


def plot_study_cgan(
    renderers,
    positions,
    atlas,
    speed_accuracy_renderers_svg,
    atlas_positions_svg,
    atlas_cgan_svg,
    source,
):
    save_figure(
        speed_accuracy_renderers_svg,
        study_cgan.speed_accuracy_renderers(read_table(renderers)),
        source,
    )
    save_figure(atlas_positions_svg, study_cgan.atlas_positions(read_table(positions)), source)
    save_figure(atlas_cgan_svg, study_cgan.atlas_cgan(read_table(atlas)), source)


run(plot_study_cgan)
