"""Fill the tables of README.md and docs/accuracy.md from results/: ``python docs/fill_tables.py [results]``.

A block stands between ``<!-- name -->`` and ``<!-- /name -->``; what was there is replaced. So every number on these
pages has a file it came from, and a run of the default configuration renews them all. Blocks whose tables a run did not
write stay as they are and are named on stderr.
"""

import re
import sys
from pathlib import Path

import pandas as pd
from rulegraph import mermaid, read_rules
from study_tables import STUDY_BLOCKS
from table_parts import METRICS, SETS, amount, digits, markdown, read, share

ROOT = Path(__file__).resolve().parents[1]
PAGES = (ROOT / "README.md", ROOT / "docs/accuracy.md")
METHODS = ("cgan", "phy")


def similarity(results):
    """Table II."""
    table = read(results, "table2").set_index(["metric", "statistic"])
    n_scenes = read(results, "table3_intervals")["n_images"].iloc[0]
    rows = [
        [
            name,
            *(" / ".join(f"{table.loc[(m, s), method]:.{n}f}" for s in ("min", "mean", "max")) for method in METHODS),
        ]
        for m, (name, n) in METRICS.items()
    ]
    title = f"**Similarity of the renders of the {n_scenes} test masks to the observed scenes** (`table2.csv`),"
    return title + " min / mean / max:" + "\n\n" + markdown(["metric", "cGAN", "PHY"], rows)


def trackers(results):
    """Table III."""
    table = read(results, "table3").set_index("output")
    n_replicas = read(results, "table3_intervals")["n_replicas"].iloc[0]
    rows = [
        [output.replace("_", " "), *("/".join(share(row[f"{s}_{m}"]) for m in ("ods", "ois", "ap")) for s in SETS)]
        for output, row in table.iterrows()
    ]
    title = f"**Edge scores of the trackers**, ODS / OIS / AP, means of {n_replicas} trainings (`table3.csv`):"
    return title + "\n\n" + markdown(["output", *SETS.values()], rows)


def intervals(results):
    """Differences of the fuse to training on real scenes alone."""
    table = read(results, "table3_intervals").set_index(["output", "training_set", "metric"])
    rows = []
    for metric in ("ods", "ois", "ap"):
        cells = [
            table.loc[("fuse", s, metric), ["difference", "difference_low", "difference_high"]]
            for s in SETS
            if s != "rd"
        ]
        rows.append([metric.upper(), *(f"{c.iloc[0]:+.3f} [{c.iloc[1]:+.3f}, {c.iloc[2]:+.3f}]" for c in cells)])
    title = (
        "Difference of the fused output to RD, with 95 % intervals of the paired bootstrap over images and trainings\n"
        "(`table3_intervals.csv`):"
    )
    return title + "\n\n" + markdown(["", *(name for s, name in SETS.items() if s != "rd")], rows)


def tables(results):
    """What README shows of results."""
    return "\n\n".join(block(results) for block in (similarity, trackers, intervals))


def graph(_):
    """The stages as a flowchart."""
    return "```mermaid\n" + mermaid(read_rules()) + "```"


def closed_loop(results):
    """What comes back of the statistics that went into PHY."""
    table = read(results, "closed_loop_summary")
    rows = [
        [
            f"`{r.quantity}`",
            f"{amount(r.bound, r.unit)}",
            f"{r.n_within} of {r.n}",
            amount(r.median, r.unit),
            amount(r.median_standard_error, r.unit),
            "" if pd.isna(r.reasons) else r.reasons,
        ]
        for r in table.itertuples()
    ]
    return markdown(["quantity", "bound", "within", "median error", "its sampling", "reasons of those beyond"], rows)


def conventions(results):
    """Score of every convention of PHY in the closed loop."""
    table = read(results, "closed_loop_conventions").sort_values("score")
    rows = [
        [f"`{r.estimator}`", f"`{r.normalise}`", f"`{r.align}`", f"`{r.width}`"]
        + [amount(r.peak_power_median, "relative"), amount(r.decay_rate_median, "relative")]
        + [digits(r.width_bins_median, 2), digits(r.offset_bins_median, 2), digits(r.score, 2)]
        for r in table.itertuples()
    ]
    header = [
        "estimator",
        "normalise",
        "align",
        "width",
        "power",
        "decay rate",
        "width [bins]",
        "offset [bins]",
        "score",
    ]
    return markdown(header, rows)


def waveforms(results):
    """Ways of computing the mean power."""
    fastest = quickest(read(results, "speed_accuracy_waveforms"), ["method", "setting"])
    rows = [[m, s, nanoseconds(r), error_db(r["error_db"])] for (m, s), r in fastest.iterrows()]
    return markdown(["method", "setting", "ns per pixel", "largest error [dB]"], rows)


def speckle(results):
    """Ways of drawing speckle."""
    table = read(results, "speed_accuracy_speckle").dropna(subset="seconds")
    fastest = quickest(table, ["method", "setting"])
    rows = [
        [m, s, nanoseconds(r), "" if pd.isna(r["distance"]) else f"{r['distance']:.1g}"]
        for (m, s), r in fastest.iterrows()
    ]
    return markdown(["method", "setting", "ns per pixel", "distance of the distribution function"], rows)


def scenes(results):
    """Whole scenes by every renderer."""
    fastest = quickest(read(results, "speed_accuracy_scenes"), ["method", "setting"])
    rows = [[m, s, nanoseconds(r), error_db(r["error_db"])] for (m, s), r in fastest.iterrows()]
    return markdown(["renderer", "setting", "ns per pixel", "largest error [dB]"], rows)


def plans(results):
    """What plans leave out over all label scenes."""
    names = {
        "plan_share": "pixels × layers computed, share of the full model's",
        "plan_cost_normals": "predicted cost per pixel [float32 normals]",
        "plan_bound_db": "stated error bound [dB]",
    }
    table = read(results, "phy_plan").set_index("quantity")
    rows = [[name, *(f"{table.loc[key, s]:.3g}" for s in ("min", "mean", "max"))] for key, name in names.items()]
    return markdown(["", "least", "mean", "most"], rows)


def stability(results):
    """Outcomes of the stability atlas by method."""
    table = read(results, "stability_phy_regions")
    counts = table.groupby("method", sort=False)[["n_within", "n_refused", "n_wrong"]].sum()
    return markdown(["method", "within its bound", "refused", "wrong"], [[f"`{m}`", *r] for m, r in counts.iterrows()])


def realism(results):
    """The reference flight beside published figures."""
    rows = []
    for r in read(results, "realism").dropna(subset="observed_low").itertuples():
        ours = digits(r.value, 4) if r.low == r.high else f"{digits(r.value)} ({digits(r.low)} to {digits(r.high)})"
        if pd.isna(r.observed_high):
            published = f"over {r.observed_low:g}"
        else:
            published = f"{r.observed_low:g}" + (
                "" if r.observed_low == r.observed_high else f" to {r.observed_high:g}"
            )
        rows.append([r.quantity, "" if r.unit == "1" else r.unit, ours, published, r.source])
    return markdown(["quantity", "unit", "here: mean (range)", "published", "source"], rows)


def cost(results):
    """Seconds and memory of every rule, from Snakemake's benchmarks."""
    rows = []
    for folder in sorted((results / "benchmarks").iterdir()):
        runs = pd.concat([pd.read_csv(path, sep="\t", na_values="-") for path in sorted(folder.rglob("*.tsv"))])
        rows.append([f"`{folder.name}`", len(runs), runs["s"].sum(), runs["max_rss"].max()])
    rows.sort(key=lambda row: -row[2])
    total = sum(row[2] for row in rows)
    shown = [
        [name, n, f"{s:.0f}", f"{100 * s / total:.0f} %", f"{rss:.0f}"] for name, n, s, rss in rows if s >= total / 200
    ]
    rest = [row for row in rows if row[2] < total / 200]
    shown.append([f"{len(rest)} others", sum(r[1] for r in rest), f"{sum(r[2] for r in rest):.0f}", "", ""])
    shown.append(["all", sum(r[1] for r in rows), f"{total:.0f}", "", f"{max(r[3] for r in rows):.0f}"])
    return markdown(["rule", "jobs", "seconds", "share", "largest memory of a job [MB]"], shown)


BLOCKS = (
    *(tables, graph, similarity, trackers, intervals, closed_loop, conventions),
    *(waveforms, speckle, scenes, plans, stability, realism, cost),
    *STUDY_BLOCKS,
)


def quickest(table, keys):
    """Fastest run of each method and setting, in the order of the table."""
    fastest = table.groupby(keys, sort=False)["seconds"].idxmin()
    return table.loc[fastest].set_index(keys)


def nanoseconds(row):
    """Time per pixel [ns]."""
    return digits(row["seconds"] / row["n_pixels"] * 1e9)


def error_db(value):
    """An error in dB; nothing where there is none to state."""
    return "" if pd.isna(value) else f"{value:.1g}"


def fill(text, results):
    """Text with its blocks filled, and the names of those whose tables are not there.

    Raises
    ------
    ValueError
        If a block is opened and not closed.
    """
    left = []
    for block in BLOCKS:
        name = block.__name__
        opened, closed = f"<!-- {name} -->", f"<!-- /{name} -->"
        if opened not in text:
            continue
        if closed not in text.split(opened, 1)[1]:
            msg = f"expected {closed} after {opened}, found none"
            raise ValueError(msg)
        try:
            made = block(results)
        except FileNotFoundError as error:
            left.append(f"{name} ({error.filename} is not there)")
            continue
        pattern = re.escape(opened) + ".*?" + re.escape(closed)
        text = re.sub(pattern, lambda _, made=made: f"{opened}\n{made}\n{closed}", text, count=1, flags=re.DOTALL)  # noqa: B023
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
