"""Figures of similarity."""

from main_path import run

from evaluation.lib.figures import similarity
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_table
from snowsim.io.scenes import SceneSet


def plot_similarity(
    render_positions,
    images,
    ssim_depth,
    observed,
    cgan,
    phy,
    similarity_bounds,
    worth,
    render_positions_svg,
    similarity_boxplots_svg,
    ssim_depth_svg,
    sample_svg,
    similarity_bounds_svg,
    worth_svg,
    source,
):
    images = read_table(images)
    save_figure(
        render_positions_svg,
        similarity.render_positions(*map(read_table, render_positions)),
        source,
    )
    save_figure(similarity_boxplots_svg, similarity.similarity_boxplots(images), source)
    save_figure(ssim_depth_svg, similarity.ssim_depth(*map(read_table, ssim_depth)), source)
    with SceneSet(observed) as scenes, SceneSet(cgan) as by_cgan, SceneSet(phy) as by_phy:
        sample = similarity.sample(scenes, by_cgan, by_phy, images)
        save_figure(sample_svg, sample, source)
    save_figure(
        similarity_bounds_svg,
        similarity.similarity_bounds(*map(read_table, similarity_bounds)),
        source,
    )
    save_figure(worth_svg, similarity.worth(*map(read_table, worth)), source)


run(plot_similarity)
