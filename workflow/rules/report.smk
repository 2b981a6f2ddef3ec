# One page that stands alone, from the tables and figures of the default run. Included last: it shows what others declare.


include: "reported.smk"


REPORT_FIGURES = declared_figures(reported("figures"))
STUDY_FILES = study_files()


rule write_report:
    input:
        tables=reported("tables"),
        figures=[figure["file"] for figure in REPORT_FIGURES],
        captions=[figure["caption"] for figure in REPORT_FIGURES],
        images="results/similarity.parquet",
        gallery="results/gallery.json",
        paper=ROOT / "workflow/report/paper.yaml",
        page=sorted((ROOT / "workflow/report/page").iterdir()),
        code=imported_by("write_report.py"),
    output:
        page="results/report.html",
    log:
        "logs/write_report.log",
    benchmark:
        "results/benchmarks/write_report/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        config=config,
        note=NOTE,
        figures=REPORT_FIGURES,
        studies={
            "files": STUDY_FILES,
            "figures": declared_figures(STUDY_FILES),
            "parts": study_parts(),
        },
        stages=measured_stages(),
        benchmarks="results/benchmarks",
    message:
        "the report, one page"
    script:
        "../scripts/write_report.py"


rule report:
    input:
        rules.write_report.output,
    message:
        "the report of the run, one page that stands alone"
