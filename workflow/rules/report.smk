# One page that stands alone, from the tables and figures of the default run. Included last: it shows what others declare.

import hashlib

from snakemake.io import get_flag_value

REPORT_PAGE = sorted((ROOT / "workflow/report/page").iterdir())
# What a study makes takes hours. It joins the page when it is there, and is no input: as one, a stale study would be
# rerun by the default run. The digests see to it that the page is written anew when a study's tables change.
STUDY_RULES = [
    item for item in workflow.rules if Path(item.snakefile).stem.startswith("study_")
]


def declared_figures(rules, wanted):
    """Figures that rules declare with a caption, those among `wanted`: file, caption's file, stage."""
    return [
        {
            "file": str(file),
            "caption": str((Path(item.snakefile).parent / flag.caption).resolve()),
            "stage": Path(item.snakefile).stem,
        }
        for item in rules
        for file in item.output
        if (flag := get_flag_value(file, "report")) and str(file) in wanted
    ]


def reported(folder):
    """What the default run makes under results/`folder`, in the order the stages name it."""
    return list(
        dict.fromkeys(
            str(file)
            for file in rules.all.input
            if str(file).startswith(f"results/{folder}/")
        )
    )


def study_files():
    """Tables and figures of studies that are there, by name with a digest of the content."""
    figures = [str(file) for item in STUDY_RULES for file in item.output]
    found = sorted(
        str(path)
        for path in [
            *Path("results/studies").rglob("*.csv"),
            *[Path(name) for name in figures if name.startswith("results/figures/")],
        ]
        if path.is_file()
    )
    return {
        name: hashlib.sha256(Path(name).read_bytes()).hexdigest()[:16] for name in found
    }


REPORT_FIGURES = declared_figures(
    [item for item in workflow.rules if item not in STUDY_RULES], reported("figures")
)
STUDY_FILES = study_files()


rule write_report:
    input:
        tables=reported("tables"),
        figures=[figure["file"] for figure in REPORT_FIGURES],
        captions=[figure["caption"] for figure in REPORT_FIGURES],
        images="results/similarity.parquet",
        gallery="results/gallery.json",
        paper=ROOT / "workflow/report/paper.yaml",
        page=REPORT_PAGE,
        code=package("report", "io"),
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
            "figures": declared_figures(STUDY_RULES, STUDY_FILES),
            "parts": sorted(
                {
                    Path(item.snakefile).stem.removeprefix("study_")
                    for item in STUDY_RULES
                }
            ),
        },
        stages={
            item.name: Path(item.snakefile).stem
            for item in workflow.rules
            if item.benchmark
        },
        benchmarks="results/benchmarks",
    message:
        "the report, one page"
    script:
        "../scripts/write_report.py"


rule report:
    input:
        rules.write_report.output,
    message:
        "the report, one page"
