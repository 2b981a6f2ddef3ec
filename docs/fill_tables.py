"""Fill the tables of the pages: ``python docs/fill_tables.py [--earlier WORDS] [results]``.

A block stands between ``<!-- name: stamp -->`` and ``<!-- /name -->``; what was there is replaced,
and the stamp tells of which flight, benchmark scenes and label sets it is. So every number in these
tables has a file it came from, and a run of the default configuration renews them all. A run of
another flight than that whose statistics the package holds is refused.

Blocks whose tables a run did not write, or wrote before its flight or its label sets, stay as they
are and are named on stderr. With ``--earlier WORDS`` those of another stamp are marked on the page
as "of an earlier WORDS".
"""

from pathlib import Path

import click
import pandas as pd
import stamps
from study_tables import STUDY_BLOCKS, STUDY_FILES
from table_parts import METRICS, SETS, amount, difference, digits, error, markdown, read, share
from transfer_tables import TRANSFER_BLOCKS

ROOT = Path(__file__).resolve().parents[1]
EDGE_METRICS = ("ods", "ois", "ap")
ENOUGH_TRAININGS = 5  # of each set, for intervals to be more than indicative
PAGES = (
    ROOT / "README.md",
    ROOT / "docs/accuracy.md",
    ROOT / "docs/reference-flight.md",
    ROOT / "docs/stages/track.md",
)
PACKAGED = ROOT / "snowsim/data/reference_flight.nc"  # statistics of the flight in use


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
    """Rows of the tracker's study that compare default trainings with RD; none without a study.

    Nor are there any of a study of earlier label sets.
    """
    file = STUDY_FILES["worth"]
    if not (results / file).is_file() or stamps.is_stale(results, file):
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


def difficulty(results):
    """The benchmark beside the paper's."""
    real = read(results, "realism").set_index("quantity")
    shallow = real.loc["test scenes of fewer than 6 layers"]
    most = real.loc["most layers of a test scene"]
    intervals = read(results, "table3_intervals").set_index(["output", "training_set", "metric"])
    fuse = intervals.loc[("fuse", "rd", "ods")]
    n_scenes = f"{fuse['n_images']:.0f}"
    rows = [
        [shallow.name, f"{100 * shallow['value']:.0f} % of {n_scenes}", "57 % of 260"],
        [most.name, f"{most['value']:.0f} (among {n_scenes} scenes)", "34 (among 260)"],
    ]
    trained = f"{share(fuse['mean'])}, mean of {fuse['n_replicas']:.0f} trainings (`table3.csv`)"
    rows.append(["fuse ODS of a tracker trained on RD", trained, ".815"])
    return markdown(["", "this flight", "Yari et al. (2021)"], rows)


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
    difficulty,
    cost,
    *STUDY_BLOCKS,
    *TRANSFER_BLOCKS,
)


class StaleTableError(Exception):
    """A study's table is of an earlier flight, or of earlier label sets."""


def made(name, results):
    """Text of a block by a run. StaleTableError or FileNotFoundError where this has none."""
    file = STUDY_FILES.get(name)
    if file and (results / file).is_file() and stamps.is_stale(results, file):
        msg = f"{file} is older than the run's statistics or label sets"
        raise StaleTableError(msg)
    maker = next(block for block in BLOCKS if block.__name__ == name)
    try:
        return f"{maker(results)}\n"
    except FileNotFoundError as missing:
        msg = f"{missing.filename} is not there"
        raise FileNotFoundError(msg) from missing


def fill(text, results, stamp, earlier=""):
    """Text with its blocks filled, and the names of those that are left, with the reasons.

    `earlier` are the words that mark blocks which are left and have another stamp.
    ValueError if a block is opened and not closed.
    """
    left = []
    for old in stamps.blocks_of(text):
        try:
            new = stamps.Block(old.name, stamp, made(old.name, results))
        except (FileNotFoundError, StaleTableError) as reason:
            left.append(f"{old.name} ({reason})")
            is_stale = old.has_table and old.stamp != stamp and not old.is_marked
            new = old.marked(earlier) if earlier and is_stale else old
        text = text.replace(str(old), str(new))
    return text, left


@click.command()
@click.argument("results", type=click.Path(path_type=Path), default=ROOT / "results")
@click.option("--earlier", default="", metavar="WORDS", help="Mark tables left: of an earlier ...")
def main(results, earlier):
    """Fill all pages."""
    of_run = stamps.of_statistics(results / "statistics.nc")
    in_use = stamps.of_statistics(PACKAGED)
    if of_run != in_use:
        msg = f"{results}: expected a run of flight {in_use}, the package's, found flight {of_run}"
        raise click.ClickException(msg)
    stamp = stamps.of_run(results)
    for page in PAGES:
        text, left = fill(page.read_text(), results, stamp, earlier)
        page.write_text(text)
        for name in left:
            click.echo(f"{page.name}: left as it is: {name}", err=True)


if __name__ == "__main__":
    main()
