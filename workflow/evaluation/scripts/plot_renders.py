"""Figures of the renders of label sets."""

from main_path import run

from evaluation.lib.figures import renders
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_table
from snowsim.io.scenes import SceneSet


def plot_renders(
    losses,
    validation,
    samples,
    train,
    test,
    phy,
    cgan,
    cgan_losses_svg,
    cgan_samples_png,
    annotation_svg,
    synthetic_svg,
    n_labels,
    source,
):
    losses = renders.cgan_losses(read_table(losses), read_table(validation))
    save_figure(cgan_losses_svg, losses, source)
    with SceneSet(samples) as scenes:
        save_figure(cgan_samples_png, renders.cgan_samples(scenes), source)
    with SceneSet(train) as scenes:
        save_figure(annotation_svg, renders.annotation(scenes, source), source)
    with SceneSet(test) as observed, SceneSet(phy) as by_phy, SceneSet(cgan) as by_cgan:
        synthetic = renders.synthetic(observed, by_phy, by_cgan, n_labels, source)
        save_figure(synthetic_svg, synthetic, source)


run(plot_renders)
