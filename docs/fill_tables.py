"""Fill the tables of README.md and of pages: ``python docs/fill_tables.py [results]``.

A block stands between ``<!-- name -->`` and ``<!-- /name -->``; what was there is replaced. So
every number on these pages has a file it came from, and a run of the default configuration renews
them all. Blocks whose tables a run did not write stay as they are and are named on stderr.
"""

import sys
from pathlib import Path

import pandas as pd
from study_tables import STUDY_BLOCKS
from table_parts import METRICS, SETS, amount, difference, digits, error, markdown, read, share
from transfer_tables import TRANSFER_BLOCKS

ROOT = Path(__file__).resolve().parents[1]
EDGE_METRICS = ("ods", "ois", "ap")
ENOUGH_TRAININGS = 5  # of each set, for intervals to be more than indicative
PAGES = (ROOT / "README.md", ROOT / "docs/accuracy.md", ROOT / "docs/stages/track.md")


def similarity(results):
    """Table II."""
    table = read(results, "table2").set_index(["metric", "statistic"])
    n_scenes = read(results, "table3_intervals")["n_images"].iloc[0]
    rows = []
    for metric, (name, n) in METRICS.items():
        of_metric = table.loc[metric].loc[["min", "mean", "max"]]
        row = [name]
        for method in ("cgan", "phy"):
            row.append(" / ".join(f"{value:.{n}f}" for value in of_metric[method]))
        rows.append(row)
    what = f"Similarity of the renders of the {n_scenes} test masks to the observed scenes"
    title = f"**{what}** (`table2.csv`), min / mean / max:\n\n"
    return title + markdown(["metric", "cGAN", "PHY"], rows)


def trackers(results):
    """Table III."""
    table = read(results, "table3").set_index("output")
    n_replicas = read(results, "table3_intervals")["n_replicas"].iloc[0]
    rows = []
    for output, scores in table.iterrows():
        row = [output.replace("_", " ")]
        for name in SETS:
            row.append("/".join(share(scores[f"{name}_{metric}"]) for metric in EDGE_METRICS))
        rows.append(row)
    what = f"ODS / OIS / AP, means of {n_replicas} trainings (`table3.csv`)"
    title = f"**Edge scores of the trackers**, {what}:\n\n"
    return title + markdown(["output", *SETS.values()], rows)


def intervals(results):
    """Differences of the fuse to training on real scenes alone.

    They are the study's, where it has more trainings.
    """
    table = read(results, "table3_intervals").query("output == 'fuse'")
    n = table["n_replicas"].iloc[0]
    table = table.assign(low=table["difference_low"], high=table["difference_high"])
    method = "the paired bootstrap over images and trainings (`table3_intervals.csv`)."
    if n < ENOUGH_TRAININGS:
        method += f" {n} trainings a set are too few for more than an indication"
    study = of_defaults(results)
    if len(study) and study["n_replicas"].iloc[0] > n:
        n = study["n_replicas"].iloc[0]
        table = study
        method = "Student's t over trainings and images (`studies/tracker/worth.csv`)"
    table = table.set_index(["training_set", "metric"])
    added = {key: name for key, name in SETS.items() if key != "rd"}
    rows = []
    for metric in EDGE_METRICS:
        differences = [difference(table.loc[(key, metric)]) for key in added]
        rows.append([metric.upper(), *differences])
    title = (
        f"Difference of the fused output to RD, {n} trainings a set,\n95 % intervals of {method}:"
    )
    return title + "\n\n" + markdown(["", *added.values()], rows)


def of_defaults(results):
    """Rows of the tracker's study that compare default trainings with RD; none without a study."""
    if not (results / "studies/tracker/worth.csv").is_file():
        return pd.DataFrame()
    query = "setting == 'default' and base == 'default' and base_training_set == 'rd'"
    return read(results, "worth", "studies/tracker").query(query)


def picks(results):
    """Errors of picks followed through the fused output."""
    by_set = read(results, "picks").groupby("training_set", sort=False)
    table = by_set.mean(numeric_only=True).loc[list(SETS)]
    n_layers = table["n_layers"].iloc[0]
    rows = [
        ["mean absolute error [bins]", *table["mean_absolute_error_bins"].map("{:.2f}".format)],
        ["share of errors within 2 bins", *table["share_within"].map(share)],
        ["share of layer pixels picked", *table["share_found"].map(share)],
        [f"layers missed, of {n_layers:.0f}", *table["n_missed_layers"].map("{:.0f}".format)],
        ["false layers", *table["n_false_layers"].map("{:.0f}".format)],
    ]
    how = "followed through the fused output, at the threshold of its ODS (`picks.csv`)"
    return f"**Picks** {how}, means of trainings:\n\n" + markdown(["", *SETS.values()], rows)


def two_sample(results):
    """How often classifiers tell observed scenes from others."""
    table = read(results, "two_sample")
    names = {"observed": "observed, other half", "phy": "PHY", "cgan": "cGAN"}
    rows = []
    for (name, first_row), cells in table.groupby(["scenes", "first_row"], sort=False):
        cells = cells.set_index("classifier").loc[["network", "texture"]]
        shares = [f"{c.accuracy:.2f} [{c.low:.2f}, {c.high:.2f}]" for c in cells.itertuples()]
        patches = "all" if first_row < 0 else f"from bin {first_row}"
        rows.append([names[name], patches, *shares])
    return markdown(["observed and", "patches", "network", "texture"], rows)


def tables(results):
    """What README shows of results."""
    return "\n\n".join(block(results) for block in (similarity, trackers, intervals, picks))


def closed_loop(results):
    """Statistics re-estimated from PHY's renders against those that went in."""
    rows = []
    for r in read(results, "closed_loop_summary").itertuples():
        bound = amount(r.bound, r.unit)
        median = amount(r.median, r.unit)
        sampling = amount(r.median_standard_error, r.unit)
        reasons = "" if pd.isna(r.reasons) else r.reasons
        within = f"{r.n_within} of {r.n}"
        rows.append([f"`{r.quantity}`", bound, within, median, sampling, reasons])
    header = ["quantity", "bound", "within", "median error", "its sampling"]
    return markdown([*header, "reasons of those beyond"], rows)


def conventions(results):
    """Score of every convention of PHY in the closed loop."""
    table = read(results, "closed_loop_conventions").sort_values("score")
    names = ["estimator", "normalise", "align", "width"]
    rows = []
    for _, row in table.iterrows():
        options = [f"`{row[name]}`" for name in names]
        shares = row[["peak_power_median", "decay_rate_median"]]
        others = row[["width_bins_median", "offset_bins_median", "score"]]
        percent = [amount(value, "relative") for value in shares]
        rows.append([*options, *percent, *[digits(value, 2) for value in others]])
    return markdown([*names, "power", "decay rate", "width [bins]", "offset [bins]", "score"], rows)


def waveforms(results):
    """Ways of computing the mean power."""
    table = read(results, "speed_accuracy_waveforms")
    return timed(table, "method", "error_db", "largest error [dB]")


def speckle(results):
    """Ways of drawing speckle."""
    table = read(results, "speed_accuracy_speckle").dropna(subset="seconds")
    return timed(table, "method", "distance", "distance of the distribution function")


def scenes(results):
    """Whole scenes by every renderer."""
    table = read(results, "speed_accuracy_scenes")
    return timed(table, "renderer", "error_db", "largest error [dB]")


def timed(table, what, quantity, title):
    """Time per pixel and error of the fastest run of each method and setting, in their order."""
    fastest = table.loc[table.groupby(["method", "setting"], sort=False)["seconds"].idxmin()]
    fastest["ns"] = fastest["seconds"] / fastest["n_pixels"] * 1e9
    rows = []
    for _, row in fastest.iterrows():
        rows.append([row["method"], row["setting"], digits(row["ns"]), error(row[quantity])])
    return markdown([what, "setting", "ns per pixel", title], rows)


def plans(results):
    """What plans leave out over all label scenes."""
    names = {
        "plan_share": "pixels × layers computed, share of the full model's",
        "plan_cost_normals": "predicted cost per pixel [float32 normals]",
        "plan_bound_db": "stated error bound [dB]",
    }
    table = read(results, "phy_plan").set_index("quantity")[["min", "mean", "max"]]
    rows = [[name, *table.loc[key].map("{:.3g}".format)] for key, name in names.items()]
    return markdown(["", "least", "mean", "most"], rows)


def atlas(results):
    """Outcomes of the atlas of PHY by method."""
    table = read(results, "atlas_phy_regions")
    counts = table.groupby("method", sort=False)[["n_within", "n_refused", "n_wrong"]].sum()
    rows = [[f"`{method}`", *of_method] for method, of_method in counts.iterrows()]
    return markdown(["method", "within its bound", "refused", "wrong"], rows)


def realism(results):
    """The reference flight beside real Snow Radar and printed figures."""
    rows = []
    for r in read(results, "realism").itertuples():
        ours = digits(r.value)
        if pd.notna(r.low) and r.low != r.high:
            ours += f" ({digits(r.low)} to {digits(r.high)})"
        real = digits(r.real_low)
        if pd.notna(r.real_low) and r.real_low != r.real_high:
            real += f" to {digits(r.real_high)}"
        unit = "" if r.unit == "1" else r.unit
        agrees = r.agrees if r.comparable else f"not compared: {r.reason}"
        rows.append([r.quantity, unit, ours, real, agrees])
    return markdown(["quantity", "unit", "here: value (95 % interval)", "real", "agrees"], rows)


def cost(results):
    """Seconds and memory of every rule, from Snakemake's benchmarks."""
    found = []
    for path in sorted((results / "benchmarks").rglob("*.tsv")):
        rule = path.relative_to(results / "benchmarks").parts[0]
        found.append(pd.read_csv(path, sep="\t", na_values="-").assign(rule=rule))
    runs = pd.concat(found)
    rules = runs.groupby("rule").agg(jobs=("s", "size"), s=("s", "sum"), mb=("max_rss", "max"))
    rules = rules.sort_values("s", ascending=False, kind="stable")
    total = rules["s"].sum()
    is_large = rules["s"] >= total / 200
    rows = []
    for r in rules[is_large].itertuples():
        percent = f"{100 * r.s / total:.0f} %"
        rows.append([f"`{r.Index}`", r.jobs, f"{r.s:.0f}", percent, f"{r.mb:.0f}"])
    rest = rules[~is_large]
    rows.append([f"{len(rest)} others", rest["jobs"].sum(), f"{rest['s'].sum():.0f}", "", ""])
    rows.append(["all", len(runs), f"{total:.0f}", "", f"{rules['mb'].max():.0f}"])
    return markdown(["rule", "jobs", "seconds", "share", "largest memory of a job [MB]"], rows)


BLOCKS = (
    tables,
    similarity,
    trackers,
    intervals,
    picks,
    two_sample,
    closed_loop,
    conventions,
    waveforms,
    speckle,
    scenes,
    plans,
    atlas,
    realism,
    cost,
    *STUDY_BLOCKS,
    *TRANSFER_BLOCKS,
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
