"""Fill README's table and pictures from a finished default run.

``python docs/fill_tables.py [RESULTS]`` replaces what stands between ``<!-- results -->`` and
``<!-- /results -->``, draws ``docs/sample.png`` and copies ``docs/speed_accuracy.png``. Every other
table on the pages is typed.
"""

import shutil
from pathlib import Path

import click
import numpy as np
import pandas as pd
from matplotlib import pyplot as plt

import snowsim
from snowsim.echogram import SURFACE_ROW, layer_bins_of, to_db
from snowsim.io import read_echogram
from snowsim.io.scenes import SceneSet

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
OPENED, CLOSED = "<!-- results -->\n", "<!-- /results -->"
SETS = {"rd": "RD", "rd_gd": "RD+GD", "rd_pd": "RD+PD", "rd_pd_gd": "RD+PD+GD"}
RENDERER = {"rd_gd": "cgan", "rd_pd": "phy"}  # of the scenes that a set adds
SIMILARITY = {"ssim": ("SSIM", 2), "psnr": ("PSNR [dB]", 1), "rmse": ("RMSE [grey levels]", 1)}
# Of the picture: a frame and its first range lines, the first synthetic scene of so many layers,
# and how much is seen of them.
FRAME = "0015"
N_LINES = 512
LEAST_LAYERS = 14
N_ROWS = 300
BIN_M = 0.0336  # of snow of 340 kg m-3 in a range bin of 2.886e-10 s
LINE_KM = 0.0052
SHOWN_PERCENT = (0.5, 99.9)  # of the powers of the echogram, from black to white
TITLES = (
    "echogram; right half: layers as tracked",
    "synthetic layers, by PHY",
    "the same, by the cGAN",
)


def markdown(header, rows):
    """A table as Markdown, of rows of text."""
    lines = [f"| {' | '.join(row)} |" for row in rows]
    title = f"| {' | '.join(header)} |"
    return "\n".join([title, "|---" * len(header) + "|", *lines]) + "\n"


def edge_scores(results):
    """Rows of the fused output's scores, with their differences to RD and 95 % intervals."""
    table = pd.read_csv(results / "tables/table3.csv").set_index("output")
    intervals = pd.read_csv(results / "tables/table3_intervals.csv").query("output == 'fuse'")
    by_score = intervals.set_index(["metric", "training_set"])
    rows = []
    for metric in ("ods", "ois", "ap"):
        row = [metric.upper()]
        for name in SETS:
            cell = f"{table.loc['fuse', f'{name}_{metric}']:.3f}".removeprefix("0")
            if name != "rd":
                low, high = by_score.loc[(metric, name), ["difference_low", "difference_high"]]
                cell += f" [{low:+.3f}, {high:+.3f}]"
            row.append(cell)
        rows.append(row)
    return rows


def similarity(results):
    """Rows of Table II's means, each below the training set that the renderer's scenes are in."""
    table = pd.read_csv(results / "tables/table2.csv").query("statistic == 'mean'")
    mean = table.set_index("metric")
    rows = []
    for metric, (name, n_digits) in SIMILARITY.items():
        cells = []
        for training_set in SETS:
            method = RENDERER.get(training_set)
            cells.append(f"{mean.loc[metric, method]:.{n_digits}f}" if method else "")
        rows.append([f"renders: {name}", *cells])
    return rows


def filled(page, results):
    """Text of a page with the table of a run. ValueError if the page has no place for it."""
    before, opened, rest = page.partition(OPENED)
    _, closed, after = rest.partition(CLOSED)
    if not (opened and closed):
        msg = f"expected {OPENED.strip()} and {CLOSED}, found no such place"
        raise ValueError(msg)
    header = ["", *SETS.values()]
    table = markdown(header, edge_scores(results) + similarity(results))
    return f"{before}{OPENED}{table}{CLOSED}{after}"


def sample(results):
    """Figure of an echogram with its tracked layers beside a synthetic scene by both renderers."""
    lines = slice(N_LINES)
    echogram = read_echogram(results / f"flight/{FRAME}.nc").isel(slow_time=lines)
    layers = snowsim.Tracker.from_pretrained("universal").pick(echogram)
    power_db = to_db(echogram["Data"].transpose("twtt", "slow_time"))
    layer_bins = layer_bins_of(layers, echogram)
    top = int(np.median(layer_bins[0])) - SURFACE_ROW
    darkest_db, brightest_db = np.percentile(power_db[top : top + N_ROWS], SHOWN_PERCENT)
    images = [255 * (power_db[top:] - darkest_db) / (brightest_db - darkest_db)]
    for method in ("phy", "cgan"):
        with SceneSet(results / f"{method}/labels/0000.nc") as scenes:
            drawn = next(scene for scene in scenes if len(scene.layer_bins) > LEAST_LAYERS)
        images.append(drawn.image)
    figure, axes = plt.subplots(
        1, 3, figsize=(10, 4), sharey=True, layout="constrained", width_ratios=(2, 1, 1)
    )
    depth_m = BIN_M * (np.array([N_ROWS, 0]) - SURFACE_ROW)
    for ax, image, title in zip(axes, images, TITLES, strict=True):
        extent = (0, image.shape[1] * LINE_KM, *depth_m)
        ax.imshow(image[:N_ROWS], "gray", vmin=0, vmax=255, extent=extent, aspect="auto")
        ax.set(title=title, xlabel="along track [km]")
    right = np.arange(N_LINES // 2, N_LINES)
    below_m = BIN_M * (layer_bins[:, right].T - top - SURFACE_ROW)
    axes[0].plot(LINE_KM * (right + 0.5), below_m, linewidth=1.2)
    axes[0].set(ylabel="depth [m]", ylim=depth_m)
    return figure


@click.command()
@click.argument("results", type=click.Path(path_type=Path), default=ROOT / "results")
def main(results):
    """Fill README's table and pictures."""
    README.write_text(filled(README.read_text(), results))
    sample(results).savefig(ROOT / "docs/sample.png", dpi=110)
    shutil.copy(results / "figures/speed_accuracy.png", ROOT / "docs")


if __name__ == "__main__":
    main()
