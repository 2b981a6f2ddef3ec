"""The report: one page from the run's tables and figures."""

from pathlib import Path

from job import job

from lib.diagnostics.claims import judge_claims
from lib.machine import describe_machine, describe_versions
from lib.report.content import (
    TRAINING_SETS,
    compare_table2,
    compare_table3,
    count_verdicts,
    counterparts,
    stage_costs,
    summary_tiles,
    title_of,
)
from lib.report.format import FILTERS, config_lines
from lib.report.page import figure_uri, file_uri, read_benchmarks, read_json, read_text, read_yaml, write_page
from snowsim.io.files import read_table

PREVIEW_ROWS = 6


def described_figures(figures):
    """Figures with their content, caption, title and an anchor."""
    described = []
    for figure in figures:
        caption = " ".join(read_text(figure["caption"]).split())
        described.append(
            {
                **figure,
                "name": Path(figure["file"]).stem,
                "caption": caption,
                "title": title_of(caption),
                "uri": figure_uri(figure["file"]),
            }
        )
    return described


def table_name(path):
    """Name of a table for the download: its own, or that of a study's with the study before it."""
    parts = Path(path).parts
    return "_".join(parts[parts.index("studies") + 1 :]) if "studies" in parts else parts[-1]


def described_tables(paths):
    """Tables with their content for the download, their size and first rows."""
    described = []
    for path in paths:
        table = read_table(path)
        described.append(
            {
                "name": table_name(path),
                "uri": file_uri(path),
                "n_bytes": Path(path).stat().st_size,
                "n_rows": len(table),
                "columns": list(table.columns),
                "rows": table.head(PREVIEW_ROWS).astype(object).to_numpy().tolist(),
            }
        )
    return described


def write_report(inputs, path_to_page, config, note, figures, studies, stages, benchmarks):
    paper = read_yaml(inputs.paper)
    tables = {Path(path).stem: read_table(path) for path in inputs.tables}
    claims = judge_claims({**tables, "similarity": read_table(inputs.images)})
    figures = described_figures(figures)
    costs = stage_costs(read_benchmarks(benchmarks), stages)
    study_tables = [path for path in studies["files"] if path.endswith(".csv")]
    context = {
        "note": note,
        "synthetic": config["source"] == "reference",
        "source_words": f"the {note}" if config["source"] == "reference" else note,
        "paper": paper,
        "table2": compare_table2(tables["table2"], paper["table2"]),
        "table3": compare_table3(tables["table3_intervals"], paper["table3"]),
        "training_sets": TRAINING_SETS,
        "n_replicas": int(tables["table3_intervals"]["n_replicas"].iloc[0]),
        "claims": claims,
        "figures": figures,
        "counterparts": counterparts(figures, paper["figures"]),
        "studies": {**studies, "figures": described_figures(studies["figures"])},
        "study_tables": described_tables(study_tables),
        "tables": described_tables(inputs.tables),
        "gallery": read_json(inputs.gallery),
        "costs": costs,
        "total_wall_s": sum(stage["wall_s"] for stage in costs),
        "tiles": summary_tiles(tables, claims, costs),
        "verdict_counts": count_verdicts(claims),
        "machine": describe_machine(),
        "versions": describe_versions(),
        "seed": config["seed"],
        "config": config_lines(config),
    }
    write_page(path_to_page, Path(inputs.page[0]).parent, "page.html.j2", context, FILTERS)


if __name__ == "__main__":
    with job(snakemake):
        write_report(snakemake.input, *snakemake.output, **snakemake.params)
