"""Fill README's table of results from those of a finished default run.

``python docs/fill_tables.py [RESULTS]`` replaces what stands between ``<!-- results -->`` and
``<!-- /results -->``. Every other table on the pages is typed.
"""

from pathlib import Path

import click
import pandas as pd

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
OPENED, CLOSED = "<!-- results -->\n", "<!-- /results -->"
SETS = {"rd": "RD", "rd_gd": "RD+GD", "rd_pd": "RD+PD", "rd_pd_gd": "RD+PD+GD"}


def markdown(header, rows):
    """A table as Markdown, of rows of text."""
    lines = [f"| {' | '.join(row)} |" for row in rows]
    title = f"| {' | '.join(header)} |"
    return "\n".join([title, "|---" * len(header) + "|", *lines]) + "\n"


def similarity(results):
    """Table II's means."""
    table = pd.read_csv(results / "tables/table2.csv").query("statistic == 'mean'")
    mean = table.set_index("metric")
    digits = {"ssim": ("SSIM", 2), "psnr": ("PSNR [dB]", 1), "rmse": ("RMSE", 1)}
    rows = []
    for metric, (name, n) in digits.items():
        cgan, phy = mean.loc[metric, ["cgan", "phy"]]
        rows.append([name, f"{cgan:.{n}f}", f"{phy:.{n}f}"])
    return markdown(["mean over test scenes", "cGAN", "PHY"], rows)


def edge_scores(results):
    """Scores of the fused output, and their differences to RD with 95 % intervals."""
    table = pd.read_csv(results / "tables/table3.csv").set_index("output")
    intervals = pd.read_csv(results / "tables/table3_intervals.csv").query("output == 'fuse'")
    by_score = intervals.set_index(["metric", "training_set"])
    n_trainings = intervals["n_replicas"].iloc[0]
    rows = []
    for metric in ("ods", "ois", "ap"):
        row = [metric.upper()]
        for name in SETS:
            cell = f"{table.loc['fuse', f'{name}_{metric}']:.3f}".removeprefix("0")
            if name != "rd":
                against_rd = by_score.loc[(metric, name)]
                low, high = against_rd[["difference_low", "difference_high"]]
                cell += f" ({against_rd['difference']:+.4f} [{low:+.4f}, {high:+.4f}])"
            row.append(cell)
        rows.append(row)
    title = f"fused output, means of {n_trainings} trainings (less RD [95 %])"
    return markdown([title, *SETS.values()], rows)


def filled(page, results):
    """Text of a page with the table of a run. ValueError if the page has no place for it."""
    before, opened, rest = page.partition(OPENED)
    _, closed, after = rest.partition(CLOSED)
    if not (opened and closed):
        msg = f"expected {OPENED.strip()} and {CLOSED}, found no such place"
        raise ValueError(msg)
    return f"{before}{OPENED}{similarity(results)}\n{edge_scores(results)}{CLOSED}{after}"


@click.command()
@click.argument("results", type=click.Path(path_type=Path), default=ROOT / "results")
def main(results):
    """Fill README's table."""
    README.write_text(filled(README.read_text(), results))


if __name__ == "__main__":
    main()
