"""Tables as the workflow writes them, with planted numbers, for tests of what reads them."""

from itertools import product

import pandas as pd

SETS = ("rd", "rd_gd", "rd_pd", "rd_pd_gd")
OUTPUTS = (*(f"side_{side}" for side in range(1, 6)), "fuse")


def table2(cgan, phy):
    """Table II of the same lowest, mean and highest value for every metric."""
    rows = product(("ssim", "psnr", "rmse"), zip(("min", "mean", "max"), cgan, phy, strict=True))
    return pd.DataFrame(
        [(metric, *row) for metric, row in rows], columns=["metric", "statistic", "cgan", "phy"]
    )


def table3_intervals(differences=None, half_width=0.005, outputs=OUTPUTS):
    """Table III's intervals, the differences to RD planted by (output, training set) or none."""
    table = pd.DataFrame(
        product(outputs, SETS, ("ods", "ois", "ap")), columns=["output", "training_set", "metric"]
    )
    keys = zip(table["output"], table["training_set"], strict=True)
    difference = pd.Series([(differences or {}).get(key, 0.0) for key in keys])
    table = table.assign(
        mean=0.8 + difference, low=0.78, high=0.82, n_replicas=2, n_images=60, difference=difference
    )
    return table.assign(
        difference_low=difference - half_width, difference_high=difference + half_width
    )


def worth(n_replicas, **values):
    """The tracker study's scores beside those of RD, the same for every training set and metric."""
    rows = [
        ("default", name, "default", "rd", metric)
        for name, metric in product(SETS[1:], ("ods", "ois", "ap"))
    ]
    names = ["setting", "training_set", "base", "base_training_set", "metric"]
    return pd.DataFrame(rows, columns=names).assign(n_replicas=n_replicas, **values)


def picks():
    """Errors of picks of two trainings a set: 0.5 and 1.5 bins, the same counts."""
    rows = [
        (name, replica, 0.5 + replica, 0.9, 0.75, 40, 5, 7)
        for name, replica in product(SETS, range(2))
    ]
    names = ["training_set", "replica", "mean_absolute_error_bins", "share_within", "share_found"]
    return pd.DataFrame(rows, columns=[*names, "n_layers", "n_missed_layers", "n_false_layers"])
