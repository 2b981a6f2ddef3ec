# One page that stands alone, from the tables and figures of the default run.


# Tables and figures of the default run, each once.
SHOWN = dict.fromkeys([*rules.similarity.input, *rules.trackers.input, *JUDGED])
# What a study makes takes hours. It joins the page when it is there, and is no input of it: as one, a stale study would
# be rerun by the default run. Digests of it are parameters: they have the page written anew when one changes.
STUDY_FILES = [
    *[file for file, stage in FIGURES.items() if stage.startswith("study_")],
    *sorted(map(str, Path("results/studies").glob("*/*.csv"))),
]


rule write_report:
    input:
        tables=[file for file in SHOWN if file.startswith("results/tables/")],
        figures=[file for file in SHOWN if file in FIGURES],
        observed=benchmark_files("test"),
        cgan=rendered_files("cgan", "test"),
        phy=rendered_files("phy", "test"),
        images="results/similarity.parquet",
        statistics="results/statistics.nc",
        paper=ROOT / "workflow/evaluation/report/paper.yaml",
        template=sorted((ROOT / "workflow/evaluation/report/page").iterdir()),
        code=imported_by(EVALUATION / "write_report.py"),
    output:
        gallery="results/gallery.json",
        page="results/report.html",
    log:
        "logs/write_report.log",
    benchmark:
        "results/benchmarks/write_report/all.tsv"
    params:
        config=config,
        note=NOTE,
        n_scenes=16,
        captions={
            file: (stage, " ".join(caption_file(file).read_text().split()))
            for file, stage in FIGURES.items()
        },
        studies={
            "files": finished(STUDY_FILES),
            "parts": sorted(
                item.name.removeprefix("study_") for item in targets("study_")
            ),
        },
        printed=(
            finished(PRINTED_TABLES)
            if all(map(os.path.isfile, PRINTED_TABLES))
            else {}
        ),
        # Stage of every rule whose jobs are measured, by the folder of its measurements.
        stages={
            Path(str(item.benchmark)).parts[2]: Path(item.snakefile).stem
            for item in workflow.rules
            if str(item.benchmark).startswith("results/benchmarks/")
        },
        benchmarks="results/benchmarks",
    message:
        "the report, one page"
    script:
        "../scripts/write_report.py"


rule report:
    input:
        rules.write_report.output.page,
    message:
        "the report of the run, one page"
