"""Tables as the workflow writes them, with planted numbers, for tests of what reads them."""

from itertools import product

import pandas as pd

SETS = ("rd", "rd_gd", "rd_pd", "rd_pd_gd")
METRICS = ("ods", "ois", "ap")
OUTPUTS = ("side_1", "side_2", "side_3", "side_4", "side_5", "fuse")


def table2(cgan, phy):
    """Table II of the same lowest, mean and highest value for every metric."""
    of_metric = pd.DataFrame({"statistic": ["min", "mean", "max"], "cgan": cgan, "phy": phy})
    metrics = pd.DataFrame({"metric": ["ssim", "psnr", "rmse"]})
    return metrics.merge(of_metric, how="cross")


def table3_intervals(differences, half_width=0.005, outputs=OUTPUTS):
    """Table III's intervals, the differences to RD planted by (output, training set)."""
    keys = product(outputs, SETS, METRICS)
    table = pd.DataFrame(keys, columns=["output", "training_set", "metric"])
    of_rows = zip(table["output"], table["training_set"], strict=True)
    difference = pd.Series([differences.get(row, 0.0) for row in of_rows])
    table["mean"] = 0.8 + difference
    table["low"] = 0.78
    table["high"] = 0.82
    table["n_replicas"] = 2
    table["n_images"] = 60
    table["difference"] = difference
    table["difference_low"] = difference - half_width
    table["difference_high"] = difference + half_width
    return table


def table3_equal(**ods):
    """Table III with equal gradients: fused ODS of some sets."""
    return pd.DataFrame({"output": ["fuse"]} | {f"{name}_ods": [n] for name, n in ods.items()})


def closed_loop():
    """Two peak powers 1 and 5 % off, a width a bin off."""
    rows = [("peak_power", 0.01), ("peak_power", -0.05), ("width_bins", 1.0)]
    table = pd.DataFrame(rows, columns=["quantity", "error"])
    table = table.assign(unit=["relative", "relative", "bins"], bound=[0.03, 0.03, 1.0])
    return table.assign(within=table["error"].abs() <= table["bound"])


def picks():
    """Errors of picks of two trainings a set: 0.5 and 1.5 bins, the same counts."""
    table = pd.DataFrame(product(SETS, range(2)), columns=["training_set", "replica"])
    return table.assign(
        mean_absolute_error_bins=0.5 + table["replica"],
        share_within=0.9,
        share_found=0.75,
        n_layers=40,
        n_missed_layers=5,
        n_false_layers=7,
    )
