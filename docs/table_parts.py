"""What tables on the pages are made of: files of a run, Markdown, numbers as they are printed."""

import pandas as pd

SETS = {"rd": "RD", "rd_gd": "RD+GD", "rd_pd": "RD+PD", "rd_pd_gd": "RD+PD+GD"}
RUNS = {**SETS, "gd": "GD", "pd": "PD"}  # and drawn scenes alone
METRICS = {"ssim": ("SSIM", 2), "psnr": ("PSNR [dB]", 1), "rmse": ("RMSE", 1)}


def markdown(header, rows):
    """A table as Markdown; the first column is text, the others are taken as they come."""
    lines = [f"| {' | '.join(map(str, cells))} |" for cells in (header, *rows)]
    lines.insert(1, "|" + "---|" * len(header))
    return "\n".join(lines)


def read(results, name, folder="tables"):
    """A table of results/tables, or of another folder."""
    return pd.read_csv(results / folder / f"{name}.csv")


def difference(row):
    """A difference with its 95 % interval."""
    return f"{row.difference:+.4f} [{row.low:+.4f}, {row.high:+.4f}]"


def digits(value, n=3):
    """A number with this many digits, written out; nothing for NaN."""
    return "" if pd.isna(value) else f"{float(f'{value:.{n}g}'):,.15g}"


def amount(value, unit):
    """A number in its unit; shares as percent."""
    if pd.isna(value):
        return ""
    return f"{100 * value:.1f} %" if unit == "relative" else f"{value:.2g} {unit}"


def error(value):
    """An error with one digit; nothing where there is none to state."""
    return "" if pd.isna(value) else f"{value:.1g}"


def share(value):
    """A score without its leading zero, as the papers print it."""
    return f"{value:.3f}".removeprefix("0")
