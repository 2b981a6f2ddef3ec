"""Captions as written for figures: their title, and the figures of the paper they name.

Tables II and III of a run beside the paper's.
What a run cost, stage by stage, from the benchmark files of its jobs.
The few numbers a reader sees first.
"""

import re

import pandas as pd

from lib.diagnostics.verdicts import CONFIRMED, CONTRADICTED, MISSING, OPEN
from lib.report.format import duration, signed3

FIGURES = re.compile(r"paper, Figs? (\d+)(?:(?:-| to )(\d+)|(?:, (\d+))? and (\d+))?")
LONGEST_TITLE = 110


def paper_figures(caption):
    """Numbers of the paper's figures that a caption names ("paper, Fig. 8", "Figs 6 and 7", "Figs 10-12"), sorted."""
    numbers = set()
    for first, last, *others in FIGURES.findall(caption.replace("Fig.", "Fig")):
        numbers |= set(range(int(first), int(last or first) + 1)) | {int(number) for number in others if number}
    return sorted(numbers)


def title_of(caption):
    """The first clause of a caption, without what stands in brackets, at most 110 characters."""
    plain = re.sub(r"\s*\([^)]*\)", "", " ".join(caption.split()))
    title = re.split(r"[:.;](?:\s|$)", plain, maxsplit=1)[0]
    if len(title) > LONGEST_TITLE:
        title = title[:LONGEST_TITLE].rsplit(" ", 1)[0] + " ..."
    return title


def counterparts(figures, paper_numbers):
    """Which figures of the report answer each of the paper's.

    Parameters
    ----------
    figures : list of dict
        With `name` and `caption`.
    paper_numbers : iterable of int

    Returns
    -------
    dict
        Number -> list of the figures whose captions name it.
    """
    return {number: [f for f in figures if number in paper_figures(f["caption"])] for number in paper_numbers}


TRAINING_SETS = {"rd": "RD", "rd_gd": "RD+GD", "rd_pd": "RD+PD", "rd_pd_gd": "RD+PD+GD"}
METRICS = {"ssim": ("SSIM", 2), "psnr": ("PSNR [dB]", 1), "rmse": ("RMSE", 1)}
SCORES = ("ods", "ois", "ap")
STATISTICS = ("min", "mean", "max")


def compare_table2(table2, paper):
    """Rows of Table II: metric, method, and ours and the paper's as "min / mean / max".

    Parameters
    ----------
    table2 : pandas.DataFrame
        Columns `metric`, `statistic`, `cgan`, `phy`.
    paper : dict
        metric -> method -> [min, mean, max].

    Returns
    -------
    list of dict
        `metric`, `method`, `ours`, `paper`, texts.
    """
    ours = table2.set_index(["metric", "statistic"])
    rows = []
    for metric, (name, digits) in METRICS.items():
        for method, label in (("cgan", "cGAN"), ("phy", "PHY")):
            values = [ours.loc[(metric, statistic), method] for statistic in STATISTICS]
            rows.append(
                {
                    "metric": name,
                    "method": label,
                    "ours": " / ".join(f"{value:.{digits}f}" for value in values),
                    "paper": " / ".join(f"{value:.{digits}f}" for value in paper[metric][method]),
                }
            )
    return rows


def compare_table3(intervals, paper):
    """Rows of Table III: output and score, and for every training set ours, its difference to RD, and the paper's.

    Parameters
    ----------
    intervals : pandas.DataFrame
        Columns `output`, `training_set`, `metric`, `mean`, `low`, `high`, `difference`, `difference_low`,
        `difference_high`.
    paper : dict
        output -> training set -> [ODS, OIS, AP].

    Returns
    -------
    list of dict
        `output`, `score`, and `cells`: per training set a dict of `mean`, `low`, `high`, `difference`, its ends,
        `resolved` (the interval of the difference leaves out zero) and `paper`.
    """
    ours = intervals.set_index(["output", "metric", "training_set"])
    rows = []
    for output, published in paper.items():
        for k, score in enumerate(SCORES):
            cells = []
            for training_set in TRAINING_SETS:
                row = ours.loc[(output, score, training_set)].to_dict()
                resolved = row["difference_low"] > 0 or row["difference_high"] < 0
                cells.append({**row, "resolved": resolved, "paper": published[training_set][k]})
            name = output.replace("_", " ")
            rows.append({"output": name, "score": score.upper(), "cells": cells})
    return rows


GIBIBYTE_MB = 1024


def stage_costs(jobs, stages):
    """Cost of every stage and of every rule in it.

    Parameters
    ----------
    jobs : pandas.DataFrame
        A row per job: `rule`, `s` [wall seconds], `cpu_time` [s], `max_rss` [MB].
    stages : dict
        Rule -> stage; rules that are not in it are left out, their files are of an older run.

    Returns
    -------
    list of dict
        `stage`, `n_jobs`, `wall_s`, `cpu_s`, `memory_gb` (largest of a job) and `rules`, the same per rule, in the
        order of `stages`.
    """
    jobs = jobs[jobs["rule"].isin(list(stages))]
    numbers = {name: pd.to_numeric(jobs[name], errors="coerce") for name in ("s", "cpu_time", "max_rss")}
    jobs = jobs.assign(**numbers)
    found = []
    for stage in dict.fromkeys(stages.values()):
        rules = [rule for rule, of in stages.items() if of == stage]
        parts = [_cost(rule, jobs[jobs["rule"] == rule]) for rule in rules if (jobs["rule"] == rule).any()]
        if parts:
            whole = _cost(stage, jobs[jobs["rule"].isin(rules)])
            found.append({"stage": stage, **{k: v for k, v in whole.items() if k != "rule"}, "rules": parts})
    return found


def _cost(name, jobs):
    return {
        "rule": name,
        "n_jobs": len(jobs),
        "wall_s": float(jobs["s"].sum()),
        # Jobs that end between two looks of the clock have no CPU time on file.
        "cpu_s": float(jobs["cpu_time"].sum()),
        "memory_gb": float(jobs["max_rss"].max()) / GIBIBYTE_MB,
    }


def count_verdicts(claims):
    """How many claims got each verdict, without verdicts that none got."""
    counts = {name: sum(claim.verdict == name for claim in claims) for name in (CONFIRMED, CONTRADICTED, OPEN, MISSING)}
    return {name: count for name, count in counts.items() if count}


def summary_tiles(tables, claims, costs):
    """Names, values and notes of the summary: similarity, tracker, what augmentation gains, claims, time."""
    table2 = tables["table2"].set_index(["metric", "statistic"])
    fuse = tables["table3_intervals"]
    fuse = fuse[(fuse["output"] == "fuse") & (fuse["metric"] == "ods")].set_index("training_set")
    added = fuse.drop(index="rd")
    best = added["mean"].idxmax()
    row = added.loc[best]
    interval = f"[{signed3(row['difference_low'])}, {signed3(row['difference_high'])}]"
    ssim, psnr = table2.loc[("ssim", "mean")], table2.loc[("psnr", "mean")]
    counts = count_verdicts(claims)
    return [
        {
            "name": "SSIM with observed scenes",
            "value": f"cGAN {ssim['cgan']:.2f}, PHY {ssim['phy']:.2f}",
            "note": f"PSNR cGAN {psnr['cgan']:.1f} dB, PHY {psnr['phy']:.1f} dB; means over test scenes",
        },
        {
            "name": "Tracker on RD alone, fused ODS",
            "value": f"{fuse.loc['rd', 'mean']:.3f}",
            "note": f"95 % interval {fuse.loc['rd', 'low']:.3f} to {fuse.loc['rd', 'high']:.3f}",
        },
        {
            "name": "Best augmented set, fused ODS",
            "value": f"{TRAINING_SETS[best]} {signed3(row['difference'])}",
            "note": f"over RD, 95 % interval {interval}",
        },
        {
            "name": "The paper's claims",
            "value": f"{counts.get(CONFIRMED, 0)} of {len(claims)} confirmed",
            "note": ", ".join(f"{count} {name}" for name, count in counts.items() if name != CONFIRMED),
        },
        {
            "name": "Time of all jobs",
            "value": duration(sum(stage["wall_s"] for stage in costs)),
            "note": f"{sum(stage['n_jobs'] for stage in costs)} jobs, CPU {duration(sum(s['cpu_s'] for s in costs))}",
        },
    ]
