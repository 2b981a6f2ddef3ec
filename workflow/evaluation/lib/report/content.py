"""What the page says: figures, tables beside the paper's, what the run cost, the summary."""

import re
from collections import Counter
from pathlib import Path

import yaml

from evaluation.lib.claim_rules import CONFIRMED, CONTRADICTED, MISSING, OPEN
from evaluation.lib.claims import ENOUGH_TRAININGS, check_claims, trainings
from evaluation.lib.figures.style import METHODS, NAMES, TRAINING_SETS
from evaluation.lib.machine import describe_machine, describe_versions
from evaluation.lib.report.format import config_lines, duration, signed3
from evaluation.lib.report.page import figure_uri, file_uri, read_benchmarks
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
    """All that the page's template names.

    `studies` holds the `files` they left and the `parts` that there are; `printed` are the tables
    of the run as printed, by path, all or none.
    """
    paper = yaml.safe_load(Path(paper).read_text(encoding="utf-8"))
    figures = described_figures(figures, captions)
    by_name = tables_by_name(tables)
    as_printed = tables_by_name(printed)
    study_tables = [path for path in studies["files"] if path.endswith(".csv")]
    study_figures = [path for path in studies["files"] if path not in study_tables]
    intervals = with_study(by_name["table3_intervals"], study_tables)
    measured = {**by_name, "table3_intervals": intervals, "similarity": images, "config": config}
    synthetic = config["source"] == "reference"
    claims = check_claims(measured, synthetic=synthetic)
    costs = stage_costs(read_benchmarks(benchmarks), stages)
    n_replicas = intervals.groupby("output")["n_replicas"].max()
    return {
        "note": note,
        "synthetic": synthetic,
        "source_words": f"the {note}" if synthetic else note,
        "paper": paper,
        "table2": compare_table2(by_name["table2"], paper["table2"], as_printed.get("table2")),
        "table3": compare_table3(intervals, paper["table3"], as_printed.get("table3_intervals")),
        "as_printed": bool(printed),
        "picks": errors_of_picks(by_name["picks"]),
        "two_sample": distinguished(by_name["two_sample"]),
        "training_sets": [NAMES[name] for name in TRAINING_SETS],
        "n_replicas": n_replicas.to_dict(),
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


def tables_by_name(paths):
    """Tables by the names of their files."""
    return {Path(path).stem: read_table(path) for path in paths}


def with_study(intervals, study_tables):
    """Table III's intervals, with the study's means and differences if it has more trainings.

    `study_tables` are paths of what studies left. Only the fused output's means and differences to
    RD change; the interval of a mean stays that of the default run.
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
    differences = {"low": "difference_low", "high": "difference_high"}
    added = worth.assign(output="fuse").rename(columns=differences)
    added = added.set_index(keys)[["mean", "difference", *differences.values(), "n_replicas"]]
    base = worth.drop_duplicates("metric").assign(output="fuse", training_set="rd")
    base = base.set_index(keys)[["base_mean", "n_replicas"]].rename(columns={"base_mean": "mean"})
    updated = intervals.set_index(keys)
    updated.update(added)
    updated.update(base)
    return updated.reset_index()


def described_figures(paths, captions):
    """Figures with a name, content, stage, caption and title.

    `captions` holds stage and caption by path.
    """
    described = []
    for path in paths:
        stage, caption = captions[path]
        figure = {
            "name": Path(path).stem,
            "stage": stage,
            "caption": caption,
            "title": title_of(caption),
            "uri": figure_uri(path),
        }
        described.append(figure)
    return described


def title_of(caption):
    """The first clause of a caption, without what stands in brackets, at most 110 characters."""
    plain = re.sub(r"\s*\([^)]*\)", "", " ".join(caption.split()))
    title = re.split(r"[:.;](?:\s|$)", plain, maxsplit=1)[0]
    if len(title) > LONGEST_TITLE:
        title = title[:LONGEST_TITLE].rsplit(" ", 1)[0] + " ..."
    return title


def paper_figures(caption):
    """Numbers of the paper's figures that a caption names, sorted.

    It names them as in "paper, Fig. 8", "Figs 6 and 7", "Figs 10-12".
    """
    numbers = set()
    for first, last, *others in PAPER_FIGURES.findall(caption.replace("Fig.", "Fig")):
        numbers.update(range(int(first), int(last or first) + 1))
        numbers.update(int(number) for number in others if number)
    return sorted(numbers)


def counterparts(figures, paper_numbers):
    """Figures whose captions name a figure of the paper, lists by its number."""
    found = {number: [] for number in paper_numbers}
    for figure in figures:
        for number in paper_figures(figure["caption"]):
            if number in found:
                found[number].append(figure)
    return found


def described_tables(paths):
    """Tables with their content for the download, their size and first rows.

    A study's are named after it, too.
    """
    described = []
    for path in map(Path, paths):
        table = read_table(path)
        of_study = "studies" in path.parts
        shown = {
            "name": f"{path.parent.name}_{path.name}" if of_study else path.name,
            "uri": file_uri(path),
            "n_bytes": path.stat().st_size,
            "n_rows": len(table),
            "columns": list(table.columns),
            "rows": table.head(PREVIEW_ROWS).astype(object).to_numpy().tolist(),
        }
        described.append(shown)
    return described


def compare_table2(table2, paper, printed=None):
    """Rows of Table II as texts: metric, method, and ours, as printed and the paper's.

    The last three are "min / mean / max".
    """
    rows = []
    for metric, digits in DIGITS.items():
        for method in METHODS:
            row = {
                "metric": NAMES[metric],
                "method": NAMES[method],
                "ours": least_mean_most(table2, metric, method, digits),
                "printed": "",
                "paper": joined_numbers(paper[metric][method], digits),
            }
            if printed is not None:
                row["printed"] = least_mean_most(printed, metric, method, digits)
            rows.append(row)
    return rows


def least_mean_most(table2, metric, method, digits):
    """One metric of one method as "min / mean / max"."""
    of_metric = table2.query("metric == @metric").set_index("statistic")[method]
    return joined_numbers(of_metric[["min", "mean", "max"]], digits)


def joined_numbers(values, digits):
    """Numbers as "0.1 / 0.2 / 0.3"."""
    return " / ".join(f"{value:.{digits}f}" for value in values)


def compare_table3(intervals, paper, printed=None):
    """Rows of Table III: output, score, a cell a training set.

    A cell is `resolved` where its difference to RD is not zero.
    """
    keys = ["output", "metric", "training_set"]
    ours = intervals.set_index(keys)
    as_printed = {} if printed is None else printed.set_index(keys)["mean"]
    rows = []
    for output, published in paper.items():
        for k, score in enumerate(("ods", "ois", "ap")):
            cells = []
            for training_set in TRAINING_SETS:
                key = (output, score, training_set)
                cell = ours.loc[key].to_dict()
                cell["resolved"] = cell["difference_low"] > 0 or cell["difference_high"] < 0
                cell["printed"] = as_printed.get(key)
                cell["paper"] = published[training_set][k]
                cells.append(cell)
            rows.append({"output": output.replace("_", " "), "score": NAMES[score], "cells": cells})
    return rows


def errors_of_picks(picks):
    """Rows of texts on picks followed through the fused output: a name, then a mean a set."""
    means = picks.groupby("training_set").mean(numeric_only=True).loc[list(TRAINING_SETS)]
    n_layers = means["n_layers"].iloc[0]
    names = {
        "mean_absolute_error_bins": "Mean absolute error [range bins]",
        "share_within": "Share of errors within 2 range bins",
        "share_found": "Share of layer pixels picked",
        "n_missed_layers": f"Layers missed, of {n_layers:.0f}",
        "n_false_layers": "False layers",
    }
    digits = {"mean_absolute_error_bins": 2, "share_within": 3, "share_found": 3}
    rows = []
    for column, name in names.items():
        texts = [f"{mean:.{digits.get(column, 0)}f}" for mean in means[column]]
        rows.append((name, texts))
    return rows


def distinguished(two_sample):
    """How often each classifier knows observed scenes from others, a row a kind of scenes."""
    rows = []
    for name, of_name in two_sample.query("first_row < 0").groupby("scenes", sort=False):
        scenes = "the other half of the observed" if name == "observed" else NAMES[name]
        texts = {"scenes": scenes}
        for row in of_name.itertuples():
            texts[row.classifier] = f"{row.accuracy:.2f} [{row.low:.2f}, {row.high:.2f}]"
        rows.append(texts)
    return rows


def stage_costs(jobs, stages):
    """Cost of every stage, and under `rules` of every rule in it, in the order of `stages`.

    `stages` maps rule to stage. `jobs`, a row a job: `rule`, `s` [wall seconds], `cpu_time` [s],
    `max_rss` [MB]; of an older run's rules left out.
    """
    jobs = jobs.astype({"s": float, "cpu_time": float, "max_rss": float})
    jobs["stage"] = jobs["rule"].map(stages)
    costs = []
    for stage in dict.fromkeys(stages.values()):
        of_stage = jobs[jobs["stage"] == stage]
        if of_stage.empty:
            continue
        by_rule = dict(list(of_stage.groupby("rule")))
        parts = [{"rule": rule, **_cost(by_rule[rule])} for rule in stages if rule in by_rule]
        costs.append({"stage": stage, **_cost(of_stage), "rules": parts})
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
    """How many claims got each outcome, without outcomes that none got.

    What is true by construction is apart.
    """
    found = Counter(BUILT if claim.by_construction else claim.outcome for claim in claims)
    order = (CONFIRMED, CONTRADICTED, OPEN, MISSING, BUILT)
    return {name: found[name] for name in order if found[name]}


def summary_tiles(table2, intervals, claims, costs):
    """Names, values and notes: similarity, tracker, gain of augmentation, claims, time."""
    of_fuse = intervals.query("output == 'fuse' and metric == 'ods'").set_index("training_set")
    rd = of_fuse.loc["rd"]
    best = of_fuse["mean"].drop(index="rd").idxmax()
    gain = of_fuse.loc[best]
    interval = f"[{signed3(gain['difference_low'])}, {signed3(gain['difference_high'])}]"
    counts = count_outcomes(claims)
    n_judged = len(claims) - counts.get(BUILT, 0)
    others = [f"{count} {name}" for name, count in counts.items() if name != CONFIRMED]
    wall = duration(sum(stage["wall_s"] for stage in costs))
    cpu = duration(sum(stage["cpu_s"] for stage in costs))
    n_jobs = sum(stage["n_jobs"] for stage in costs)
    psnr = mean_by_method(table2, "psnr", ".1f", " dB")
    return [
        {
            "name": "SSIM with observed scenes",
            "value": mean_by_method(table2, "ssim", ".2f"),
            "note": f"PSNR {psnr}; means over test scenes",
        },
        {
            "name": "Tracker on RD alone, fused ODS",
            "value": f"{rd['mean']:.3f}",
            "note": f"95 % interval {rd['low']:.3f} to {rd['high']:.3f}",
        },
        {
            "name": "Best augmented set, fused ODS",
            "value": f"{NAMES[best]} {signed3(gain['difference'])}",
            "note": f"over RD, 95 % interval {interval}, {trainings(gain)}",
        },
        {
            "name": "The paper's claims",
            "value": f"{counts.get(CONFIRMED, 0)} of {n_judged} confirmed",
            "note": ", ".join(others),
        },
        {
            "name": "Time of all jobs",
            "value": wall,
            "note": f"{n_jobs} jobs, CPU {cpu}",
        },
    ]


def mean_by_method(table2, metric, form, unit=""):
    """Mean of a metric by every method, as "cGAN 0.1, PHY 0.2"."""
    means = table2.query("metric == @metric and statistic == 'mean'").iloc[0]
    return ", ".join(f"{NAMES[method]} {means[method]:{form}}{unit}" for method in METHODS)
