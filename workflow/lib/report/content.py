"""What the page says: figures and tables, the paper's tables beside this run's, what the run cost, the summary."""

import re
from pathlib import Path

import pandas as pd
import yaml

from lib.diagnostics.claim_rules import CONFIRMED, CONTRADICTED, MISSING, OPEN
from lib.diagnostics.claims import ENOUGH_TRAININGS, check_claims, trainings
from lib.figures.style import METHODS, NAMES, TRAINING_SETS
from lib.machine import describe_machine, describe_versions
from lib.report.format import config_lines, duration, signed3
from lib.report.page import figure_uri, file_uri, read_benchmarks
from snowsim.io.files import read_table

PAPER_FIGURES = re.compile(r"paper, Figs? (\d+)(?:(?:-| to )(\d+)|(?:, (\d+))? and (\d+))?")
LONGEST_TITLE = 110
PREVIEW_ROWS = 6
DIGITS = {"ssim": 2, "psnr": 1, "rmse": 1}  # of Table II
GIBIBYTE_MB = 1024
BUILT = "true by construction"


def page_content(
    gallery,
    images,
    tables,
    figures,
    captions,
    paper,
    config,
    note,
    studies,
    printed,
    stages,
    benchmarks,
):
    """All that the page's template names; `studies` holds the `files` they left and the `parts` that there are.

    `printed` are the tables of the run as printed, by path, all or none.
    """
    paper = yaml.safe_load(Path(paper).read_text(encoding="utf-8"))
    figures = described_figures(figures, captions)
    by_name = {Path(path).stem: read_table(path) for path in tables}
    printed = {Path(path).stem: read_table(path) for path in printed}
    study_tables = [path for path in studies["files"] if path.endswith(".csv")]
    intervals = with_study(by_name["table3_intervals"], study_tables)
    measured = {**by_name, "table3_intervals": intervals, "similarity": images, "config": config}
    synthetic = config["source"] == "reference"
    claims = check_claims(measured, synthetic=synthetic)
    costs = stage_costs(read_benchmarks(benchmarks), stages)
    study_figures = [path for path in studies["files"] if path not in study_tables]
    return {
        "note": note,
        "synthetic": synthetic,
        "source_words": f"the {note}" if synthetic else note,
        "paper": paper,
        "table2": compare_table2(by_name["table2"], paper["table2"], printed.get("table2")),
        "table3": compare_table3(intervals, paper["table3"], printed.get("table3_intervals")),
        "as_printed": bool(printed),
        "picks": errors_of_picks(by_name["picks"]),
        "two_sample": distinguished(by_name["two_sample"]),
        "training_sets": [NAMES[name] for name in TRAINING_SETS],
        "n_replicas": {
            of: int(intervals.set_index("output").loc[of, "n_replicas"].max())
            for of in ("fuse", "side_1")
        },
        "enough_trainings": ENOUGH_TRAININGS,
        "claims": claims,
        "figures": figures,
        "counterparts": counterparts(figures, paper["figures"]),
        "studies": {**studies, "figures": described_figures(study_figures, captions)},
        "study_tables": described_tables(study_tables),
        "tables": described_tables(tables),
        "gallery": gallery,
        "costs": costs,
        "total_wall_s": sum(stage["wall_s"] for stage in costs),
        "tiles": summary_tiles(by_name["table2"], intervals, claims, costs),
        "outcome_counts": count_outcomes(claims),
        "machine": describe_machine(),
        "versions": describe_versions(),
        "seed": config["seed"],
        "config": config_lines(config),
    }


def with_study(intervals, study_tables):
    """Table III's intervals, the fused output's means and differences to RD from the study, if it has more trainings.

    `study_tables` are paths of what studies left; the interval of a mean stays that of the default
    run.
    """
    path = next((path for path in study_tables if Path(path).match("tracker/worth.csv")), None)
    if path is None:
        return intervals
    worth = read_table(path).query(
        "setting == 'default' and base == 'default' and base_training_set == 'rd'"
    )
    if worth.empty or worth["n_replicas"].max() <= intervals["n_replicas"].max():
        return intervals
    keys = ["output", "training_set", "metric"]
    renamed = worth.rename(columns={"low": "difference_low", "high": "difference_high"}).assign(
        output="fuse"
    )
    of_base = renamed.drop_duplicates("metric").assign(
        training_set="rd", mean=lambda rows: rows["base_mean"]
    )
    columns = ["mean", "difference", "difference_low", "difference_high", "n_replicas"]
    updated = intervals.set_index(keys)
    updated.update(renamed.set_index(keys)[columns])
    updated.update(of_base.set_index(keys)[["mean", "n_replicas"]])
    return updated.reset_index()


def described_figures(paths, captions):
    """Figures with their content, stage, caption, title and a name; `captions` holds stage and caption by path."""
    described = []
    for path in paths:
        stage, caption = captions[path]
        figure = {"name": Path(path).stem, "stage": stage, "caption": caption}
        described.append({**figure, "title": title_of(caption), "uri": figure_uri(path)})
    return described


def title_of(caption):
    """The first clause of a caption, without what stands in brackets, at most 110 characters."""
    plain = re.sub(r"\s*\([^)]*\)", "", " ".join(caption.split()))
    title = re.split(r"[:.;](?:\s|$)", plain, maxsplit=1)[0]
    if len(title) > LONGEST_TITLE:
        title = title[:LONGEST_TITLE].rsplit(" ", 1)[0] + " ..."
    return title


def paper_figures(caption):
    """Numbers of the paper's figures that a caption names ("paper, Fig. 8", "Figs 6 and 7", "Figs 10-12"), sorted."""
    numbers = set()
    for first, last, *others in PAPER_FIGURES.findall(caption.replace("Fig.", "Fig")):
        numbers |= set(range(int(first), int(last or first) + 1)) | {
            int(number) for number in others if number
        }
    return sorted(numbers)


def counterparts(figures, paper_numbers):
    """Figures whose captions name a figure of the paper, lists by its number."""
    return {
        number: [f for f in figures if number in paper_figures(f["caption"])]
        for number in paper_numbers
    }


def described_tables(paths):
    """Tables with their content for the download, their size and first rows; a study's are named after it, too."""
    return [
        {
            "name": f"{path.parent.name}_{path.name}" if "studies" in path.parts else path.name,
            "uri": file_uri(path),
            "n_bytes": path.stat().st_size,
            "n_rows": len(table),
            "columns": list(table.columns),
            "rows": table.head(PREVIEW_ROWS).astype(object).to_numpy().tolist(),
        }
        for path, table in ((Path(path), read_table(path)) for path in paths)
    ]


def compare_table2(table2, paper, printed=None):
    """Rows of Table II as texts: metric, method, and ours, as printed and the paper's as "min / mean / max"."""

    def of(table, metric, method):
        if table is None:
            return []
        return (
            table.set_index(["metric", "statistic"]).loc[metric, method].loc[["min", "mean", "max"]]
        )

    def text(values, digits):
        return " / ".join(f"{value:.{digits}f}" for value in values)

    return [
        {
            "metric": NAMES[metric],
            "method": NAMES[method],
            "ours": text(of(table2, metric, method), digits),
            "printed": text(of(printed, metric, method), digits),
            "paper": text(paper[metric][method], digits),
        }
        for metric, digits in DIGITS.items()
        for method in METHODS
    ]


def compare_table3(intervals, paper, printed=None):
    """Rows of Table III: output, score, a cell a training set; `resolved`: its difference to RD is not zero."""
    keys = ["output", "metric", "training_set"]
    ours = intervals.set_index(keys)
    as_printed = None if printed is None else printed.set_index(keys)["mean"]
    rows = []
    for output, published in paper.items():
        for k, score in enumerate(("ods", "ois", "ap")):
            cells = []
            for training_set in TRAINING_SETS:
                row = ours.loc[(output, score, training_set)].to_dict()
                resolved = row["difference_low"] > 0 or row["difference_high"] < 0
                printed_mean = None if printed is None else as_printed[output, score, training_set]
                beside = {"printed": printed_mean, "paper": published[training_set][k]}
                cells.append({**row, "resolved": resolved, **beside})
            rows.append({"output": output.replace("_", " "), "score": NAMES[score], "cells": cells})
    return rows


def errors_of_picks(picks):
    """Rows of texts on picks followed through the fused output: a name, then means over trainings for every set."""
    means = picks.groupby("training_set").mean(numeric_only=True).loc[list(TRAINING_SETS)]
    shown = {
        "Mean absolute error [range bins]": ("mean_absolute_error_bins", "{:.2f}"),
        "Share of errors within 2 range bins": ("share_within", "{:.3f}"),
        "Share of layer pixels picked": ("share_found", "{:.3f}"),
        f"Layers missed, of {means['n_layers'].iloc[0]:.0f}": ("n_missed_layers", "{:.0f}"),
        "False layers": ("n_false_layers", "{:.0f}"),
    }
    return [
        (name, [text.format(value) for value in means[column]])
        for name, (column, text) in shown.items()
    ]


def distinguished(two_sample):
    """How often observed scenes are distinguished from others by each classifier, texts, a row a kind of scenes."""
    whole = two_sample[two_sample["first_row"] < 0]
    rows = []
    for name, of_name in whole.groupby("scenes", sort=False):
        texts = {
            row.classifier: f"{row.accuracy:.2f} [{row.low:.2f}, {row.high:.2f}]"
            for row in of_name.itertuples()
        }
        rows.append(
            {
                "scenes": "the other half of the observed" if name == "observed" else NAMES[name],
                **texts,
            }
        )
    return rows


def stage_costs(jobs, stages):
    """Cost of every stage, and under `rules` of every rule in it, in the order of `stages` (rule -> stage).

    `jobs`, a row a job: `rule`, `s` [wall seconds], `cpu_time` [s], `max_rss` [MB]; of an older
    run's rules left out.
    """
    jobs = jobs.assign(
        **{
            name: pd.to_numeric(jobs[name], errors="coerce")
            for name in ("s", "cpu_time", "max_rss")
        }
    )
    costs = []
    for stage in dict.fromkeys(stages.values()):
        rules = [
            rule for rule, of in stages.items() if of == stage and (jobs["rule"] == rule).any()
        ]
        if rules:
            parts = [{"rule": rule, **_cost(jobs[jobs["rule"] == rule])} for rule in rules]
            costs.append({"stage": stage, **_cost(jobs[jobs["rule"].isin(rules)]), "rules": parts})
    return costs


def _cost(jobs):
    return {
        "n_jobs": len(jobs),
        "wall_s": float(jobs["s"].sum()),
        # Jobs that end between two looks of the clock have no CPU time on file.
        "cpu_s": float(jobs["cpu_time"].sum()),
        "memory_gb": float(jobs["max_rss"].max()) / GIBIBYTE_MB,
    }


def count_outcomes(claims):
    """How many claims got each outcome, without outcomes that none got; what is true by construction apart."""
    found = [BUILT if claim.by_construction else claim.outcome for claim in claims]
    counts = {name: found.count(name) for name in (CONFIRMED, CONTRADICTED, OPEN, MISSING, BUILT)}
    return {name: count for name, count in counts.items() if count}


def summary_tiles(table2, intervals, claims, costs):
    """Names, values and notes of the summary: similarity, tracker, what augmentation gains, claims, time."""
    means = table2.set_index(["metric", "statistic"]).xs("mean", level="statistic")
    fuse = intervals[(intervals["output"] == "fuse") & (intervals["metric"] == "ods")].set_index(
        "training_set"
    )
    best = fuse["mean"].drop(index="rd").idxmax()
    rd, gain, counts = fuse.loc["rd"], fuse.loc[best], count_outcomes(claims)

    def methods(metric, digits, unit=""):
        return ", ".join(
            f"{NAMES[method]} {means.loc[metric, method]:.{digits}f}{unit}" for method in METHODS
        )

    tiles = {
        "SSIM with observed scenes": (
            methods("ssim", 2),
            f"PSNR {methods('psnr', 1, ' dB')}; means over test scenes",
        ),
        "Tracker on RD alone, fused ODS": (
            f"{rd['mean']:.3f}",
            f"95 % interval {rd['low']:.3f} to {rd['high']:.3f}",
        ),
        "Best augmented set, fused ODS": (
            f"{NAMES[best]} {signed3(gain['difference'])}",
            f"over RD, 95 % interval [{signed3(gain['difference_low'])}, {signed3(gain['difference_high'])}], "
            f"{trainings(gain)}",
        ),
        "The paper's claims": (
            f"{counts.get(CONFIRMED, 0)} of {len(claims) - counts.get(BUILT, 0)} confirmed",
            ", ".join(f"{count} {name}" for name, count in counts.items() if name != CONFIRMED),
        ),
        "Time of all jobs": (
            duration(sum(stage["wall_s"] for stage in costs)),
            f"{sum(stage['n_jobs'] for stage in costs)} jobs, CPU {duration(sum(stage['cpu_s'] for stage in costs))}",
        ),
    }
    return [{"name": name, "value": value, "note": note} for name, (value, note) in tiles.items()]
