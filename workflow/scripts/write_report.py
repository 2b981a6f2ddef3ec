"""The report: scenes of its gallery, and one page from the run's tables and figures."""

from contextlib import ExitStack
from pathlib import Path

from job import run

from lib.report.content import page_content
from lib.report.format import FILTERS
from lib.report.gallery import gallery_of
from lib.report.page import write_json, write_page
from snowsim.io.files import read_dataset, read_table
from snowsim.io.scenes import SceneSet


def write_report(
    observed, cgan, phy, images, statistics, template, gallery, page, note, n_scenes, **of_run
):
    images = read_table(images)
    with ExitStack() as opened:
        named = {"observed": observed, "cgan": cgan, "phy": phy}
        scenes = {name: opened.enter_context(SceneSet(files)) for name, files in named.items()}
        bin_size_s = float(read_dataset(statistics).attrs["bin_size_s"])
        shown = {
            "source": note,
            "bin_size_s": bin_size_s,
            "scenes": gallery_of(scenes, images, n_scenes),
        }
    write_json(gallery, shown)
    content = page_content(gallery=shown, images=images, note=note, **of_run)
    write_page(page, Path(template[0]).parent, "page.html.j2", content, FILTERS)


run(write_report)
