# ruff: noqa: E402
"""Fill the tables and pictures of README and pages from finished runs.

``python docs/fill_tables.py [RESULTS]`` replaces what stands between ``<!-- NAME -->`` and ``<!--
/NAME -->`` on every page by the table of that name, see `TABLES`, and the commit that it is of,
draws ``docs/sample.png`` and copies the figures that pages show. A table whose files are not there
is left as it is, and named.
"""

import errno
import re
import shutil
import sys
import tempfile
from pathlib import Path

import click
import numpy as np
import pandas as pd
from matplotlib import pyplot as plt

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1] / "workflow")]

from claims import claims
from table_commits import commit_line

import snowsim
from evaluation.lib.annotation import annotation_curve
from evaluation.lib.figures.studies import annotation as annotation_figure
from evaluation.lib.figures.studies import flights_depths, flights_worth
from evaluation.lib.figures.style import name_of, save_figure
from evaluation.lib.flight_scores import (
    ENDPOINT,
    SECONDARY,
    found_by_depth,
    mean_over_flights,
    share_of_deep,
    worth_table,
)
from evaluation.lib.report import distinguished, errors_of_picks, recovered
from evaluation.lib.studied import SETS as SETS_STUDIED
from snowsim.alignment import layer_bins_of
from snowsim.echogram import SURFACE_ROW, to_db
from snowsim.io import read_echogram
from snowsim.io.scenes import SceneSet

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
PAPER = ROOT / "workflow/evaluation/report/paper"
WAYS = {"universal": "tracker", "baseline": "peaks", "sato": "ridges"}
FLOWN_SCORES = "workflow/evaluation/measured_flights.csv"
FLOWN_DEPTHS = "workflow/evaluation/measured_flights_depths.csv"
ANNOTATED_SCORES = "workflow/evaluation/measured_annotation.csv"
CONTROL = ENDPOINT[1]  # the training set that the endpoint compares RD+PD with
DEPTH_STEP_BINS, DEEPEST_BINS = 100, 400  # of the table of deep layers; the last step has no end
N_COSTS = 8  # rules that a table of costs names
# Rules that are no part of the default run, by the files that hold them.
OTHER_TARGETS = ("evaluation/rules/study_*.smk", "rules/pretrained.smk")
RULE = re.compile(r"^(?:use )?rule (?:\w+ as )?(\w+)", re.MULTILINE)
DEFAULT_TABLE = "8 a bin"
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
# Rows of the table of dates, and where they are among the cases of `bench_years`.
OF_THE_TRACKER = "kind == 'tracker' and radar == 'snow-2012' and "
DATED_CASES = {
    "tracker, snow-2012, .15 m": OF_THE_TRACKER + "mass_m == .15 and crusts == 0",
    ".3 m": OF_THE_TRACKER + "mass_m == .3 and crusts == 0",
    ".6 m": OF_THE_TRACKER + "mass_m == .6 and crusts == 0",
    ".3 m, 3 crusts": OF_THE_TRACKER + "mass_m == .3 and crusts == 3",
    ".3 m, 5 crusts": OF_THE_TRACKER + "mass_m == .3 and crusts == 5",
    ".3 m, a gap along track": "kind == 'gap' and mass_m == .3",
    "cores, every horizon picked": "kind == 'core' and missing == 0",
    "cores, a fifth missing": "kind == 'core' and missing == .2",
    "cores, two fifths missing": "kind == 'core' and missing == .4",
}
LEAST_CONFIDENCE = 0.5  # of the classes that the table of confidence shows
# Of layers, in turn: no two that lie beside each other look alike, on grey.
LAYER_COLOURS = ("#ffd400", "#ff4d00", "#00c8ff")
TITLES = (
    "echogram; right half: layers as tracked (dotted: found on a part of it)",
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


def default_run(results):
    """README's table: scores of trackers, and similarity of renders."""
    return markdown(["", *SETS.values()], edge_scores(results) + similarity(results))


def signed(row):
    """A mean with its interval."""
    return f"{row['mean']:+.3f} [{row['low']:+.3f}, {row['high']:+.3f}]"


def flights(results, pairs=(ENDPOINT, *SECONDARY, ("rd_sample", "rd"))):
    """Differences over the flights of the study, of pairs whose sets were flown."""
    worth = worth_table(pd.read_csv(ROOT / FLOWN_SCORES))
    keyed = worth[worth["base"].notna()].set_index(["training_set", "base", "metric"])
    means = worth[worth["base"].isna()].set_index(["training_set", "metric"])["mean"]
    rows = []
    for name, base in pairs:
        if (name, base, "ods") not in keyed.index:
            continue
        ods, ap = (keyed.loc[(name, base, metric)] for metric in ("ods", "ap"))
        higher = ods.filter(like="flight_").astype(float) > 0
        both = f"{means[name, 'ods']:.3f}, {means[base, 'ods']:.3f}"
        label = f"{SETS_STUDIED[name].about} less {SETS_STUDIED[base].about}"
        p = ods["p_holm"] if ods["role"] == "secondary" else ods["p"]
        tested = "" if np.isnan(p) else "< 0.001" if p < 0.001 else f"{p:.3f}"
        cells = [label, both, signed(ods), tested, signed(ap), f"{higher.sum()} of {higher.size}"]
        rows.append(cells)
    return markdown(["sets", "means of ODS", "ODS", "p", "AP", "higher in ODS"], rows)


def headline(results):
    """README's table of the study: its endpoint, other controls, and what the control has."""
    others = (("rd_pd", "rd_completed"), ("rd_pd", "rd"), ("rd_sample", "rd"))
    return flights(results, (ENDPOINT, *others))


def deep_layers(results):
    """Share of layers' pixels found by depth over the flights, and the difference of deep ones."""
    depths = pd.read_csv(ROOT / FLOWN_DEPTHS)
    step = depths["depth_from_bins"].clip(upper=DEEPEST_BINS) // DEPTH_STEP_BINS
    sums = depths.groupby(["training_set", step])[["n_true", "n_found"]].sum()
    shares = (sums["n_found"] / sums["n_true"]).unstack()
    deep = share_of_deep(depths)
    rows = []
    for name in (name for name in SETS_STUDIED if name in deep.index):
        more = [
            "" if name == base else signed(mean_over_flights(deep.loc[name] - deep.loc[base]))
            for base in ("rd", CONTROL)
        ]
        rows.append([SETS_STUDIED[name].about, *map(hundredths, shares.loc[name]), *more])
    tops = [f"{number * DEPTH_STEP_BINS}-" for number in shares]
    return markdown(["from range bin", *tops, "from 300, less RD", "less the control"], rows)


def annotation(results):
    """ODS by number of annotated scenes, and how many of them PHY's scenes are worth."""
    curve = annotation_curve(pd.read_csv(ROOT / ANNOTATED_SCORES))
    most = curve["n_scenes"].max()
    header, columns = ["annotated scenes"], []
    for flight, rows in curve.groupby("flight"):
        alone, with_pd = (rows[rows["with_pd"] == kind].set_index("n_scenes") for kind in (0, 1))
        header += [f"flight {flight}: RD", "RD+PD", "worth"]
        worth = with_pd["worth"].map(lambda n: f"> {most}" if np.isnan(n) else f"{n:.0f}")
        columns += [alone["ods"].map("{:.3f}".format), with_pd["ods"].map("{:.3f}".format), worth]
    rows = [
        [str(n), *(column[n] for column in columns)] for n in sorted(curve["n_scenes"].unique())
    ]
    return markdown(header, rows)


def table2(results):
    """Similarity of renders beside the paper's."""
    ours, paper = (
        pd.read_csv(path).set_index(["metric", "statistic"])
        for path in (results / "tables/table2.csv", PAPER / "table2.csv")
    )
    rows = []
    for metric, (name, n_digits) in SIMILARITY.items():
        row = [name]
        for source in (ours, paper):
            for method in ("cgan", "phy"):
                values = source.loc[metric].loc[["min", "mean", "max"], method]
                row.append(" / ".join(f"{value:.{n_digits}f}" for value in values))
        rows.append(row)
    return markdown(["metric", "cGAN", "PHY", "paper: cGAN", "paper: PHY"], rows)


def table3(results):
    """ODS / OIS / AP of every output, differences to RD, and the paper's fused output."""
    ours, paper = (
        pd.read_csv(path).set_index("output")
        for path in (results / "tables/table3.csv", PAPER / "table3.csv")
    )
    intervals = pd.read_csv(results / "tables/table3_intervals.csv")
    fused = intervals[intervals["output"] == "fuse"].set_index(["metric", "training_set"])
    rows = []
    for output in ours.index:
        rows.append([output.replace("_", " "), *scores_of(ours.loc[output])])
    at_validation = [f"{ours.loc['fuse', f'{name}_f']:.3f}" for name in SETS]
    rows.append(["fuse, F at validation's threshold", *at_validation])
    for metric in ("ods", "ap"):
        cells = [""]
        for name in list(SETS)[1:]:
            found = fused.loc[(metric, name)].filter(like="difference")
            cells.append(signed(found.set_axis(["mean", "low", "high"])))
        rows.append([f"fuse less RD, {metric.upper()}", *cells])
    rows.append(["paper: fuse", *scores_of(paper.loc["fuse"])])
    return markdown(["output", *SETS.values()], rows)


def scores_of(row):
    """ODS/OIS/AP of every training set in a row of Table III."""
    return [
        "/".join(f"{row[f'{name}_{metric}']:.3f}" for metric in ("ods", "ois", "ap"))
        for name in SETS
    ]


def picks(results):
    """Errors of picks."""
    table = errors_of_picks(pd.read_csv(results / "tables/picks.csv"))
    return markdown(["", *SETS.values()], table.to_numpy().tolist())


def two_sample(results):
    """How often a network tells observed scenes from others."""
    table = distinguished(pd.read_csv(results / "tables/two_sample.csv"))
    return markdown(list(table), table.to_numpy().tolist())


def closed_loop(results):
    """Errors of statistics re-estimated from PHY's renders."""
    table = recovered(pd.read_csv(results / "tables/closed_loop.csv"))
    return markdown(list(table), table.astype(str).to_numpy().tolist())


def as_printed(results):
    """Table III by the paper's own choices."""
    table = pd.read_csv(results / "as_printed/tables/table3.csv").set_index("output")
    return markdown(["", *SETS.values()], [["ODS/OIS/AP", *scores_of(table.loc["fuse"])]])


def budgets(results):
    """ODS on validation scenes by training set and number of gradients, as kept for the chart."""
    scores = pd.read_csv(ROOT / "workflow/evaluation/measured_budgets.csv")
    means = scores.groupby(["training_set", "n_gradients"])["ods"].mean().unstack()
    rows = []
    for name, of_set in means.iterrows():
        best = of_set.idxmax()
        cells = ["" if np.isnan(ods) else f"{ods:.3f}" for ods in of_set]
        cells[means.columns.get_loc(best)] = f"**{of_set[best]:.3f}**"
        rows.append([SETS_STUDIED[name].about, *cells])
    return markdown(["gradients", *map(str, means.columns)], rows)


def joining(results):
    """Layers and rightly dated horizons with and without joining of pieces, by tuning flight."""
    table = pd.read_csv(ROOT / "benchmarks/joining_by_flight.csv")
    by_way = table.set_index(["flight", "way"]).unstack()
    rows = []
    for flight, row in by_way.loc[table["flight"].unique()].iterrows():
        cells = [f"{row['layers', way]:.0f}" for way in ("joined", "pieces")]
        for name in ("found", "found_shifted"):
            cells += [f"{row[name, way]:.2f}" for way in ("joined", "pieces")]
        rows.append([name_of(flight), *cells])
    header = ["flight", "layers: joined", "pieces", "dated rightly: joined", "pieces"]
    return markdown([*header, "but for a shift: joined", "pieces"], rows)


def choices(results):
    """ODS lost without each part of the scene model, and the share of scenes that is recognised."""
    losses = pd.read_csv(ROOT / "workflow/evaluation/measured_choices.csv")
    flights = [name for name in losses if name.startswith("flight_")]
    header = ["left out", "ODS lost", *(name.replace("_", " ") for name in flights), "recognised"]
    rows = [["nothing", "", *[""] * len(flights), f"{losses['whole_told_apart'].iloc[0]:.2f}"]]
    for row in losses.to_dict("records"):
        lost = f"{row['mean']:+.3f} [{row['low']:+.3f}, {row['high']:+.3f}]"
        of_flights = [f"{row[name]:+.3f}" for name in flights]
        rows.append([row["what"], lost, *of_flights, f"{row['told_apart']:.2f}"])
    return markdown(header, rows)


def confidence(results):
    """Share of picks that are right by their confidence: mean, least and most of the cases."""
    of_firn = pd.read_csv(ROOT / "benchmarks/confidence_by_case.csv")
    of_flights = pd.read_csv(ROOT / "benchmarks/confidence_by_flight.csv")
    crusts = of_firn.query("n_crusts == 5")
    kinds = (
        ("clean firn", of_firn.query("n_crusts == 0"), "right"),
        ("five crusts, each a layer", crusts, "right"),
        ("the eight flights below, 16 scenes each", of_flights, "right"),
        ("five crusts, years alone count", crusts, "right_years"),
    )
    rows = []
    for name, cases, column in kinds:
        by_class = cases[cases["from"] >= LEAST_CONFIDENCE].groupby("from")[column]
        shares = zip(by_class.mean(), by_class.min(), by_class.max(), strict=True)
        cells = [f"{hundredths(a)} ({hundredths(b)}-{hundredths(c)})" for a, b, c in shares]
        rows.append([name, *cells])
    return markdown(["confidence", ".5-.6", ".6-.7", ".7-.8", ".8-.9", "above .9"], rows)


def transfer(results):
    """The package's tracker on flights it never saw, beside one of their own and untrained ways."""
    scores = pd.read_csv(results / "tables/transfer.csv").set_index("flight")
    ways = pd.read_csv(results / "tables/transfer_accumulation.csv")
    f = ways.pivot(index="flight", columns="tracker", values="f").loc[scores.index[:-1]]
    f.loc["mean"] = f.mean()
    rows = []
    for flight, row in scores.iterrows():
        names = ("own_ods", "ods", "f", "missed_share", "false_share")
        found = [f"{row[name]:.3f}" for name in names]
        untrained = [f"{f.loc[flight, way]:.3f}" for way in ("baseline", "sato")]
        rows.append([name_of(flight), *found, *untrained])
    header = ["flight", "own: ODS", "ODS", "F", "missed", "false", "peaks: F", "ridges: F"]
    return markdown(header, rows)


def accumulation(results):
    """Accumulation from picks of flights and climates, means over them."""
    table = pd.read_csv(results / "tables/transfer_accumulation.csv")
    group = np.where(table["flight"].str.startswith("climate"), "climates", "flights")
    columns = ["f", "bias", "rms", "inside", "correlation", "given", "wrong"]
    means = table.groupby([group, "tracker"], sort=False)[columns].mean()
    rows = []
    for (group, way), row in means.iterrows():
        cells = [f"{row[name]:.2f}" for name in columns]
        cells[1:3] = [f"{100 * row['bias']:+.1f}", f"{100 * row['rms']:.0f}"]
        rows.append([f"{group}: {WAYS.get(way, way)}", *cells])
    header = ["", "F", "bias [%]", "rms [%]", "inside", "correlation", "given", "wrong"]
    return markdown(header, rows)


def costs(results):
    """Core-seconds of the default run by rule."""
    files = [file for name in OTHER_TARGETS for file in (ROOT / "workflow").glob(name)]
    others = {rule for file in files for rule in RULE.findall(file.read_text())}
    seconds = {}
    for path in (results / "benchmarks").rglob("*.tsv"):
        rule = path.relative_to(results / "benchmarks").parts[0]
        if rule not in others:
            used = pd.read_csv(path, sep="\t", na_values="-")["s"].sum()
            seconds[rule] = seconds.get(rule, 0) + used
    if not seconds:
        raise FileNotFoundError(errno.ENOENT, "no benchmark of a job", str(results / "benchmarks"))
    longest = sorted(seconds.items(), key=lambda item: -item[1])[:N_COSTS]
    total = sum(seconds.values())
    rows = [[f"`{rule}`", f"{used:.0f}"] for rule, used in longest]
    return markdown(["rule", "core-seconds"], [*rows, ["all", f"{total:.0f}"]])


def speed(results):
    """Fastest times and errors of the ways to PHY's parts and to whole scenes."""
    table = pd.read_csv(results / "tables/speed_accuracy.csv")
    table["ns"] = table["seconds"] / table["n_pixels"] * 1e9
    keys = ["panel", "method", "setting"]
    fastest = table.groupby(keys, sort=False)[["ns", "error_db", "distance"]].min().reset_index()
    rows = []
    for row in fastest.itertuples():
        if row.setting == "floor" or (row.method == "table" and row.setting != DEFAULT_TABLE):
            continue
        error = f"{row.error_db:.2g} dB" if np.isfinite(row.error_db) else ""
        error = f"{row.distance:.1g}" if np.isfinite(row.distance) else error
        rows.append([f"{row.panel}: {row.method}, {row.setting}", f"{row.ns:.3g}", error])
    return markdown(["way", "ns a pixel", "largest error"], rows)


def of_claims(results):
    """The paper's claims."""
    return markdown(["claim", "verdict", "numbers"], claims(results))


def dates(results):
    """Share of dates that are right by the probability that they state; see `bench_years`."""
    table = pd.read_csv(ROOT / "benchmarks/years_by_class.csv")
    rows = [["right", *map(hundredths, table["right"])], ["dates", *map(str, table["n"])]]
    return markdown(["stated", *map(hundredths, table["stated"])], rows)


def dated_cases(results):
    """Dates and accumulation of some cases of `bench_years`."""
    table = pd.read_csv(ROOT / "benchmarks/years_by_case.csv")
    columns = ("stated", "right", "sure", "right_of_sure", "inside", "accumulation")
    rows = []
    for name, query in DATED_CASES.items():
        (case,) = table[table["expected"].isna()].query(query).to_dict("records")
        rows.append([name, *(hundredths(case[column]) for column in columns)])
    header = ["", "stated", "right", "sure", "right of these", "inside", "accumulation over truth"]
    return markdown(header, rows)


def agreement(results):
    """Agreement of two passes beside F against truth, by flight; see `bench_agreement`."""
    table = pd.read_csv(ROOT / "benchmarks/agreement_by_flight.csv")
    names = ("f", "share_matched", "depth_rms_m", "accumulation_rms_m_we", "share_same_year")
    rows = []
    for flight in table.to_dict("records"):
        values = ("" if np.isnan(flight[name]) else f"{flight[name]:.3f}" for name in names)
        rows.append([flight["flight"].replace("_", " "), *values, f"{flight['offset']:.2f}"])
    header = ["flight", "F", "share matched", "depth [m]", "accumulation [m w.e.]", "same year"]
    return markdown([*header, "places with an offset"], rows)


def hundredths(share):
    """Number to two decimals without the zero before the point."""
    return f"{share:.2f}".removeprefix("0")


TABLES = {
    "dates": dates,
    "dated_cases": dated_cases,
    "agreement": agreement,
    "results": default_run,
    "headline": headline,
    "flights": flights,
    "deep_layers": deep_layers,
    "annotation": annotation,
    "table2": table2,
    "table3": table3,
    "picks": picks,
    "two_sample": two_sample,
    "closed_loop": closed_loop,
    "as_printed": as_printed,
    "budgets": budgets,
    "choices": choices,
    "joining": joining,
    "confidence": confidence,
    "transfer": transfer,
    "accumulation": accumulation,
    "costs": costs,
    "speed": speed,
    "claims": of_claims,
}


def filled(page, results):
    """Text of a page with the tables of a run, and names of those whose files are not there.

    ValueError if a place is not closed or its table is none of `TABLES`.
    """
    missing = []
    for name in re.findall(r"^<!-- (\w+) -->$", page, flags=re.MULTILINE):
        opened, closed = f"<!-- {name} -->\n", f"<!-- /{name} -->"
        before, _, rest = page.partition(opened)
        _, end, after = rest.partition(closed)
        if not end or name not in TABLES:
            msg = f"{opened.strip()}: expected the name of a table, and {closed} behind it"
            raise ValueError(msg)
        try:
            table = TABLES[name](results)
        except FileNotFoundError as error:
            missing.append(f"{name}: {error.filename}")
            continue
        page = f"{before}{opened}{table}\n{commit_line(name)}{closed}{after}"
    return page, missing


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
    is_picked = np.isfinite(below_m)
    depth_of = np.where(is_picked.any(axis=0), np.nanmean(below_m, axis=0), np.inf)
    for number, layer in enumerate(np.argsort(depth_of)[: is_picked.any(axis=0).sum()]):
        style = "-" if is_picked[:, layer].all() else ":"
        colour = LAYER_COLOURS[number % len(LAYER_COLOURS)]
        axes[0].plot(LINE_KM * (right + 0.5), below_m[:, layer], style, color=colour, linewidth=1.2)
    axes[0].set(ylabel="depth [m]", ylim=depth_m)
    return figure


def draw_studies():
    """Draw the figures of the studies of flights and of annotation, from tables that are kept."""
    figures = {
        "flights_worth": flights_worth(worth_table(pd.read_csv(ROOT / FLOWN_SCORES))),
        "flights_depths": flights_depths(found_by_depth(pd.read_csv(ROOT / FLOWN_DEPTHS))),
        "annotation": annotation_figure(annotation_curve(pd.read_csv(ROOT / ANNOTATED_SCORES))),
    }
    with tempfile.TemporaryDirectory() as folder:
        for name, figure in figures.items():
            drawn = Path(folder, f"{name}.svg")
            save_figure(drawn, figure, "synthetic flights")
            shutil.copy(drawn, ROOT / "docs/_static")


@click.command()
@click.argument("results", type=click.Path(path_type=Path), default=ROOT / "results")
def main(results):
    """Fill the tables and pictures of README and pages."""
    for page in (README, *sorted((ROOT / "docs").rglob("*.md"))):
        text, missing = filled(page.read_text(), results)
        page.write_text(text)
        for what in missing:
            click.echo(f"{page.relative_to(ROOT)}: left as it is: {what}")
    sample(results).savefig(ROOT / "docs/sample.png", dpi=110)
    shutil.copy(results / "figures/speed_accuracy.png", ROOT / "docs")
    draw_studies()


if __name__ == "__main__":
    main()
