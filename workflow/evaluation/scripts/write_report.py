"""The report, one page from the run's tables, figures and test scenes."""

from pathlib import Path

from main_path import checkout_files, job

from evaluation.lib.report import (
    depth_scale,
    figures_by_stage,
    gallery_of,
    page_content,
    read_benchmarks,
    read_warnings,
    write_page,
)
from snowsim.io.files import read_dataset, read_table
from snowsim.io.scenes import SceneSet


def tables_by_name(paths):
    """Tables by the names of their files."""
    return {Path(path).stem: read_table(path) for path in paths}


with job(snakemake):
    config = snakemake.params.config
    # Beside those of this job: a module may put all results into a folder of its own.
    logs = Path(snakemake.log[0]).parent
    benchmarks = Path(snakemake.output.page).parent / "benchmarks"
    scenes = {
        "observed": SceneSet(snakemake.input.observed),
        "cgan": SceneSet(snakemake.input.cgan),
        "phy": SceneSet(snakemake.input.phy),
    }
    images = read_table(snakemake.input.images)
    statistics = read_dataset(snakemake.input.statistics)
    content = page_content(
        tables=tables_by_name([*snakemake.input.tables, *snakemake.params.worth]),
        paper=tables_by_name(checkout_files(snakemake.params.paper)),
        printed=tables_by_name(snakemake.params.printed),
        jobs=read_benchmarks(benchmarks, snakemake.params.rule_stages),
        warned=read_warnings(logs, snakemake.params.rule_stages),
        config=config,
        note=snakemake.params.note,
    )
    content["figures"] = figures_by_stage(
        snakemake.input.figures,
        snakemake.params.figure_stages,
        checkout_files(snakemake.params.captions),
    )
    content["gallery"] = {
        "scenes": gallery_of(scenes, images),
        **depth_scale(
            float(statistics.attrs["bin_size_s"]),
            config["tracker"]["picks"]["snow_density_kg_m3"],
        ),
    }
    template, *_ = checkout_files(snakemake.params.page)
    write_page(snakemake.output.page, template, content)
