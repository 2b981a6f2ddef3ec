"""The report: scenes of its gallery, and one page from the run's tables and figures."""

from contextlib import ExitStack
from pathlib import Path

from main_path import run

from evaluation.lib.report.content import page_content
from evaluation.lib.report.format import FILTERS
from evaluation.lib.report.gallery import depth_scale, gallery_of
from evaluation.lib.report.page import write_json, write_page
from snowsim.io.files import read_dataset, read_table
from snowsim.io.scenes import SceneSet


def write_report(
    observed,
    cgan,
    phy,
    images,
    statistics,
    template,
    gallery,
    page,
    note,
    config,
    n_scenes,
    **of_run,
):
    images = read_table(images)
    files = {"observed": observed, "cgan": cgan, "phy": phy}
    with ExitStack() as opened:
        scenes = {name: opened.enter_context(SceneSet(paths)) for name, paths in files.items()}
        shown = gallery_of(scenes, images, n_scenes)
    bin_size_s = float(read_dataset(statistics).attrs["bin_size_s"])
    scale = depth_scale(bin_size_s, config["tracker"]["picks"]["snow_density_kg_m3"])
    shown = {"source": note, "scenes": shown, **scale}
    write_json(gallery, shown)
    content = page_content(gallery=shown, images=images, note=note, config=config, **of_run)
    write_page(page, Path(template[0]).parent, "page.html.j2", content, FILTERS)


run(write_report)
