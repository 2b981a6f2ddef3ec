"""Tables II and III of a run beside the paper's."""

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
