"""Fill the tables of README.md and docs/accuracy.md from results/: ``python docs/fill_tables.py [results]``.

A block stands between ``<!-- name -->`` and ``<!-- /name -->``; what was there is replaced. So
every number on these pages has a file it came from, and a run of the default configuration renews
them all. Blocks whose tables a run did not write stay as they are and are named on stderr.
"""

import sys
from pathlib import Path

import pandas as pd
from study_tables import STUDY_BLOCKS
from table_parts import METRICS, SETS, amount, difference, digits, error, markdown, read, share

ROOT = Path(__file__).resolve().parents[1]
ENOUGH_TRAININGS = 5  # of each set, for intervals to be more than indicative
PAGES = (ROOT / "README.md", ROOT / "docs/accuracy.md")


def similarity(results):
    """Table II."""
    table = read(results, "table2").set_index(["metric", "statistic"])
    n_scenes = read(results, "table3_intervals")["n_images"].iloc[0]
    rows = []
    for metric, (name, n) in METRICS.items():
        of_metric = table.loc[metric].loc[["min", "mean", "max"]]
        rows.append(
            [
                name,
                *(" / ".join(f"{value:.{n}f}" for value in of_metric[m]) for m in ("cgan", "phy")),
            ]
        )
    title = f"**Similarity of the renders of the {n_scenes} test masks to the observed scenes** (`table2.csv`),"
    return title + " min / mean / max:" + "\n\n" + markdown(["metric", "cGAN", "PHY"], rows)


def trackers(results):
    """Table III."""
    table = read(results, "table3").set_index("output")
    n_replicas = read(results, "table3_intervals")["n_replicas"].iloc[0]
    rows = [
        [
            output.replace("_", " "),
            *("/".join(share(row[f"{s}_{m}"]) for m in ("ods", "ois", "ap")) for s in SETS),
        ]
        for output, row in table.iterrows()
    ]
    title = f"**Edge scores of the trackers**, ODS / OIS / AP, means of {n_replicas} trainings (`table3.csv`):"
    return title + "\n\n" + markdown(["output", *SETS.values()], rows)


def intervals(results):
    """Differences of the fuse to training on real scenes alone: by the study, where it has more trainings."""
    table = read(results, "table3_intervals").query("output == 'fuse'")
    n = table["n_replicas"].iloc[0]
    few = (
        f" {n} trainings a set are too few for more than an indication"
        if n < ENOUGH_TRAININGS
        else ""
    )
    title = f"95 % intervals of the paired bootstrap over images and trainings (`table3_intervals.csv`).{few}"
    table = table.drop(columns=["low", "high"]).rename(
        columns={"difference_low": "low", "difference_high": "high"}
    )
    if (results / "studies/tracker/worth.csv").is_file():
        of_defaults = "setting == 'default' and base == 'default' and base_training_set == 'rd'"
        study = read(results, "worth", "studies/tracker").query(of_defaults)
        if len(study) and study["n_replicas"].iloc[0] > n:
            n, table = study["n_replicas"].iloc[0], study
            title = "95 % intervals of Student's t over trainings and images (`studies/tracker/worth.csv`)"
    table = table.set_index(["training_set", "metric"])
    added = {key: name for key, name in SETS.items() if key != "rd"}
    metrics = ("ods", "ois", "ap")
    rows = [
        [metric.upper(), *(difference(table.loc[(key, metric)]) for key in added)]
        for metric in metrics
    ]
    title = f"Difference of the fused output to RD, {n} trainings a set,\n{title}:"
    return title + "\n\n" + markdown(["", *added.values()], rows)


def picks(results):
    """Errors of picks followed through the fused output."""
    table = (
        read(results, "picks")
        .groupby("training_set", sort=False)
        .mean(numeric_only=True)
        .loc[list(SETS)]
    )
    shown = {
        "mean absolute error [bins]": [
            f"{value:.2f}" for value in table["mean_absolute_error_bins"]
        ],
        "share of errors within 2 bins": [share(value) for value in table["share_within"]],
        "share of layer pixels picked": [share(value) for value in table["share_found"]],
        "layers missed, of {:.0f}".format(*table["n_layers"]): [
            f"{n:.0f}" for n in table["n_missed_layers"]
        ],
        "false layers": [f"{n:.0f}" for n in table["n_false_layers"]],
    }
    title = "**Picks** followed through the fused output, at the threshold of its ODS (`picks.csv`), means of trainings:"
    return (
        title
        + "\n\n"
        + markdown(["", *SETS.values()], [[name, *cells] for name, cells in shown.items()])
    )


def two_sample(results):
    """How often classifiers tell observed scenes from others."""
    table = read(results, "two_sample")
    rows = []
    for (name, first_row), cells in table.groupby(["scenes", "first_row"], sort=False):
        cells = cells.set_index("classifier").loc[["network", "texture"]]
        shares = [f"{c.accuracy:.2f} [{c.low:.2f}, {c.high:.2f}]" for c in cells.itertuples()]
        scenes = {"observed": "observed, other half", "phy": "PHY", "cgan": "cGAN"}[name]
        rows.append([scenes, "all" if first_row < 0 else f"from bin {first_row}", *shares])
    return markdown(["observed and", "patches", "network", "texture"], rows)


def tables(results):
    """What README shows of results."""
    return "\n\n".join(block(results) for block in (similarity, trackers, intervals, picks))


def closed_loop(results):
    """Statistics re-estimated from PHY's renders against those that went in."""
    rows = []
    for r in read(results, "closed_loop_summary").itertuples():
        amounts = [amount(value, r.unit) for value in (r.bound, r.median, r.median_standard_error)]
        reasons = "" if pd.isna(r.reasons) else r.reasons
        rows.append(
            [f"`{r.quantity}`", amounts[0], f"{r.n_within} of {r.n}", *amounts[1:], reasons]
        )
    return markdown(
        ["quantity", "bound", "within", "median error", "its sampling", "reasons of those beyond"],
        rows,
    )


def conventions(results):
    """Score of every convention of PHY in the closed loop."""
    table = read(results, "closed_loop_conventions").sort_values("score")
    rows = [
        [f"`{r.estimator}`", f"`{r.normalise}`", f"`{r.align}`", f"`{r.width}`"]
        + [amount(r.peak_power_median, "relative"), amount(r.decay_rate_median, "relative")]
        + [digits(r.width_bins_median, 2), digits(r.offset_bins_median, 2), digits(r.score, 2)]
        for r in table.itertuples()
    ]
    names = ["estimator", "normalise", "align", "width"]
    return markdown([*names, "power", "decay rate", "width [bins]", "offset [bins]", "score"], rows)


def waveforms(results):
    """Ways of computing the mean power."""
    return timed(
        read(results, "speed_accuracy_waveforms"), "method", "error_db", "largest error [dB]"
    )


def speckle(results):
    """Ways of drawing speckle."""
    table = read(results, "speed_accuracy_speckle").dropna(subset="seconds")
    return timed(table, "method", "distance", "distance of the distribution function")


def scenes(results):
    """Whole scenes by every renderer."""
    return timed(
        read(results, "speed_accuracy_scenes"), "renderer", "error_db", "largest error [dB]"
    )


def timed(table, what, quantity, title):
    """Fastest run of each method and setting, in the order of the table: time per pixel and error."""
    fastest = table.loc[table.groupby(["method", "setting"], sort=False)["seconds"].idxmin()]
    rows = [
        [
            row["method"],
            row["setting"],
            digits(row["seconds"] / row["n_pixels"] * 1e9),
            error(row[quantity]),
        ]
        for _, row in fastest.iterrows()
    ]
    return markdown([what, "setting", "ns per pixel", title], rows)


def plans(results):
    """What plans leave out over all label scenes."""
    names = {
        "plan_share": "pixels × layers computed, share of the full model's",
        "plan_cost_normals": "predicted cost per pixel [float32 normals]",
        "plan_bound_db": "stated error bound [dB]",
    }
    table = read(results, "phy_plan").set_index("quantity")
    rows = [
        [name, *(f"{table.loc[key, s]:.3g}" for s in ("min", "mean", "max"))]
        for key, name in names.items()
    ]
    return markdown(["", "least", "mean", "most"], rows)


def atlas(results):
    """Outcomes of the atlas of PHY by method."""
    table = read(results, "atlas_phy_regions")
    counts = table.groupby("method", sort=False)[["n_within", "n_refused", "n_wrong"]].sum()
    return markdown(
        ["method", "within its bound", "refused", "wrong"],
        [[f"`{m}`", *r] for m, r in counts.iterrows()],
    )


def realism(results):
    """The reference flight beside real Snow Radar and printed figures."""
    rows = []
    for r in read(results, "realism").itertuples():
        single = pd.isna(r.low) or r.low == r.high
        ours = (
            digits(r.value)
            if single
            else f"{digits(r.value)} ({digits(r.low)} to {digits(r.high)})"
        )
        single = pd.isna(r.real_low) or r.real_low == r.real_high
        real = digits(r.real_low) if single else f"{digits(r.real_low)} to {digits(r.real_high)}"
        agrees = r.agrees if r.comparable else f"not compared: {r.reason}"
        rows.append([r.quantity, "" if r.unit == "1" else r.unit, ours, real, agrees])
    return markdown(["quantity", "unit", "here: value (95 % interval)", "real", "agrees"], rows)


def cost(results):
    """Seconds and memory of every rule, from Snakemake's benchmarks."""
    rows = []
    for folder in sorted((results / "benchmarks").iterdir()):
        runs = pd.concat(
            [pd.read_csv(path, sep="\t", na_values="-") for path in sorted(folder.rglob("*.tsv"))]
        )
        rows.append([f"`{folder.name}`", len(runs), runs["s"].sum(), runs["max_rss"].max()])
    rows.sort(key=lambda row: -row[2])
    total = sum(row[2] for row in rows)
    shown = [
        [name, n, f"{s:.0f}", f"{100 * s / total:.0f} %", f"{rss:.0f}"]
        for name, n, s, rss in rows
        if s >= total / 200
    ]
    rest = [row for row in rows if row[2] < total / 200]
    shown.append(
        [f"{len(rest)} others", sum(r[1] for r in rest), f"{sum(r[2] for r in rest):.0f}", "", ""]
    )
    shown.append(
        ["all", sum(r[1] for r in rows), f"{total:.0f}", "", f"{max(r[3] for r in rows):.0f}"]
    )
    return markdown(["rule", "jobs", "seconds", "share", "largest memory of a job [MB]"], shown)


BLOCKS = (
    *(tables, similarity, trackers, intervals, picks, two_sample, closed_loop, conventions),
    *(waveforms, speckle, scenes, plans, atlas, realism, cost),
    *STUDY_BLOCKS,
)


def fill(text, results):
    """Text with its blocks filled, and the names of those whose tables are not there.

    ValueError if a block is opened and not closed.
    """
    left = []
    for block in BLOCKS:
        name = block.__name__
        opened, closed = f"<!-- {name} -->\n", f"<!-- /{name} -->"
        if opened not in text:
            continue
        before, after = text.split(opened, 1)
        if closed not in after:
            msg = f"expected {closed} after {opened.strip()}, found none"
            raise ValueError(msg)
        try:
            made = block(results)
        except FileNotFoundError as missing:
            left.append(f"{name} ({missing.filename} is not there)")
        else:
            text = before + opened + made + "\n" + closed + after.split(closed, 1)[1]
    return text, left


def main(results):
    """Fill all pages."""
    for page in PAGES:
        text, left = fill(page.read_text(), results)
        page.write_text(text)
        for name in left:
            sys.stderr.write(f"{page.name}: left as it is: {name}\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "results")
