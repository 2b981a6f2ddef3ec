# One page that works offline, from the tables and figures of the default run.

import re

REPORT = "workflow/evaluation/report"
TABLES = ["table2", "table3_intervals", "picks", "two_sample", "closed_loop"]
if TRACKER["n_epochs"] is None:
    TABLES.append("table3_equal")
# Of the study of flights, which the report shows if it is finished.
WORTH = "results/studies/flights/worth.csv"
# Figures of the default run, each once.
SHOWN = [file for file in dict.fromkeys(JUDGED) if file in FIGURES]


rule write_report:
    input:
        tables=expand("results/tables/{name}.csv", name=TABLES),
        figures=SHOWN,
        observed=benchmark_files("test"),
        cgan=rendered_files("cgan", "test"),
        phy=rendered_files("phy", "test"),
        images="results/similarity.csv",
        statistics="results/statistics.nc",
    output:
        page="results/report.html",
    log:
        "logs/write_report.log",
    benchmark:
        "results/benchmarks/write_report/all.tsv"
    params:
        paper=of_checkout(f"{REPORT}/paper/table2.csv", f"{REPORT}/paper/table3.csv"),
        captions=of_checkout(*map(caption_file, SHOWN)),
        # The template, then what it takes in.
        page=of_checkout(
            *(f"{REPORT}/page/{name}" for name in ("page.html.j2", "page.js", "style.css"))
        ),
        config=config,
        note=NOTE,
        figure_stages=[FIGURES[file] for file in SHOWN],
        # By the folders of benchmarks, whose names logs share: a workflow that has this one as a module may call its
        # rules otherwise.
        rule_stages={
            name[1]: Path(item.snakefile).stem
            for item in workflow.rules
            if (name := re.search(r"(?:^|/)results/benchmarks/([^/]+)", str(item.benchmark)))
        },
        printed=finished(PRINTED_TABLES) if PRINTED_IS_MADE else {},
        worth=finished([WORTH]),
    message:
        "the report, one page"
    script:
        "../scripts/write_report.py"


rule report:
    input:
        rules.write_report.output.page,
    message:
        "the report of the run, one page"
