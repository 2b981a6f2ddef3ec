"""The report: a run's tables beside the paper's, its figures and scenes, as one page."""

import base64
import io
import re
from pathlib import Path

import jinja2
import numpy as np
import pandas as pd
from PIL import Image

from evaluation.lib.figures.style import METHODS, NAMES, TRAINING_SETS, evenly_spaced
from evaluation.lib.machine import describe_machine, describe_versions
from evaluation.lib.studied import studied_set
from snowsim.io.files import written_whole
from snowsim.metrics.picks import snow_per_bin_m

# Headings of stages; a stage that is not listed is headed by its own name.
STAGES = {
    "flight": "The flight and its statistics",
    "labels": "Label sets",
    "renders": "Renders by PHY and by the conditional GAN",
    "similarity": "Similarity of renders to observed scenes",
    "tracker": "Layer trackers",
    "charts": "Speed against accuracy, and where methods fail",
    "diagnostics": "Label sets beside the flight: two-sample test, closed loop",
}
DIGITS = {"ssim": 2, "psnr": 1, "rmse": 1}  # decimals in Table II
METRICS = ("ods", "ois", "ap")
FUSED = "fuse"  # the output that trackers are judged by; those of their stages are the side outputs
ADDED = ("rd_pd", "rd")  # the pair of training sets that the result is about
N_SCENES = 16  # scenes in the gallery
LINE_STEP = 2  # range lines from one drawn point of a layer to the next
MEDIA_TYPES = {".svg": "image/svg+xml", ".png": "image/png"}
MOST_BYTES = 400_000  # size from which on figures are embedded as compressed pixels
GIBIBYTE_MB = 1024
WARNED = re.compile(r"\S+ \S+ warning: (.*)")  # in a log, after date and time


def page_content(tables, paper, printed, jobs, warned, config, note):
    """Content of the page's template by name, without figures and gallery.

    `tables` are those of this run, with `worth` if its study of flights is finished; `paper` are
    those of the paper, and `printed` those of the run as printed, empty without one; all are dicts
    by name. `jobs` has a row for each job with its rule and stage; `warned` is the table of
    `read_warnings`.
    """
    others = {"paper": paper, "printed": printed} if printed else {"paper": paper}
    table2 = {"ours": tables["table2"]}
    table3 = {}
    for source, found in others.items():
        table2[source] = found["table2"]
        table3[source] = found["table3"].set_index("output")
    intervals = tables["table3_intervals"]
    return {
        "note": note,
        "synthetic": config["source"] == "reference",
        "as_printed": bool(printed),
        "result": result(intervals),
        "control": equal_control(intervals, tables.get("table3_equal")),
        "over_flights": over_flights(tables["worth"]) if "worth" in tables else None,
        "summary": summary(tables["table2"], jobs, warned),
        "table2": compare_table2(table2),
        "table3": compare_table3(intervals, table3),
        "n_trainings": int(intervals["n_replicas"].max()),
        "picks": errors_of_picks(tables["picks"]),
        "two_sample": distinguished(tables["two_sample"]),
        "closed_loop": recovered(tables["closed_loop"]),
        "stage_costs": costs(jobs, "stage"),
        "rule_costs": costs(jobs, "rule"),
        "warned": warned,
        "machine": describe_machine(),
        "versions": describe_versions(),
        "seed": config["seed"],
        "settings": settings_of(config),
    }


def compare_table2(sources):
    """Rows of Table II; a cell for each renderer has "min / mean / max" of every source."""
    rows = []
    for metric in DIGITS:
        cells = []
        for method in METHODS:
            texts = {name: least_mean_most(of, metric, method) for name, of in sources.items()}
            cells.append(texts)
        rows.append({"name": NAMES[metric], "cells": cells})
    return rows


def least_mean_most(table2, metric, method):
    """One metric of one method as "min / mean / max"."""
    of_metric = table2[table2["metric"] == metric].set_index("statistic")
    values = of_metric.loc[["min", "mean", "max"], method]
    return " / ".join(f"{value:.{DIGITS[metric]}f}" for value in values)


def compare_table3(intervals, others):
    """Rows of Table III, the fused output first; cells have a set's mean, and other sources'.

    Cells of augmented sets also have the difference to RD, which is `resolved` if its interval
    excludes zero. `others` holds tables by source, indexed by output, with a column for each
    training set and metric.
    """
    by_key = intervals.set_index(["output", "metric", "training_set"])
    rows = []
    outputs = intervals["output"].unique()
    for output in sorted(outputs, key=lambda output: output != FUSED):
        for metric in METRICS:
            cells = []
            for name in TRAINING_SETS:
                ours = by_key.loc[(output, metric, name)]
                cell = {"ours": f"{ours['mean']:.3f}"}
                for source, table3 in others.items():
                    cell[source] = f"{table3.loc[output, f'{name}_{metric}']:.3f}"
                if name != "rd":
                    cell["difference"] = difference(ours)
                    cell["resolved"] = ours["difference_low"] > 0 or ours["difference_high"] < 0
                cells.append(cell)
            rows.append({"name": f"{output.replace('_', ' ')}, {NAMES[metric]}", "cells": cells})
    return rows


def difference(row):
    """A difference to RD and its interval, with real minus signs."""
    return signed(*row[["difference", "difference_low", "difference_high"]])


def signed(value, low, high):
    """A difference and its interval as a text."""
    return f"{value:+.3f} [{low:+.3f}, {high:+.3f}]".replace("-", "\N{MINUS SIGN}")


def errors_of_picks(picks):
    """Table of errors of the picks made from fused outputs, means over trainings, as texts."""
    means = picks.groupby("training_set").mean(numeric_only=True).loc[list(TRAINING_SETS)]
    names = {
        "mean_absolute_error_bins": ("Mean absolute error [range bins]", 2),
        "share_within": ("Share of errors within 2 range bins", 3),
        "share_found": ("Share of layer pixels picked", 3),
        "n_missed_layers": (f"Layers missed, of {means['n_layers'].iloc[0]:.0f}", 0),
        "n_false_layers": ("False layers", 0),
    }
    rows = []
    for column, (name, digits) in names.items():
        rows.append([name, *means[column].map(f"{{:.{digits}f}}".format)])
    return pd.DataFrame(rows, columns=["Picks", *map(NAMES.get, TRAINING_SETS)])


def distinguished(two_sample):
    """Table of how often a small network tells observed scenes from others, as texts."""
    of_network = two_sample.query("classifier == 'network' and first_row < 0").dropna()
    rows = []
    for row in of_network.itertuples():
        name = "the other half of the observed" if row.scenes == "observed" else NAMES[row.scenes]
        rows.append([name, f"{row.accuracy:.2f} [{row.low:.2f}, {row.high:.2f}]"])
    return pd.DataFrame(rows, columns=["Observed scenes and", "Accuracy"])


def recovered(closed_loop):
    """Table of errors of statistics re-estimated from renders, by quantity, as texts."""
    sizes = closed_loop.assign(error=closed_loop["error"].abs())
    rows = []
    for quantity, part in sizes.groupby("quantity", sort=False):
        form = "{:.1f} bins" if part["unit"].iloc[0] == "bins" else "{:.1%}"
        median, bound = (form.format(part[name].median()) for name in ("error", "bound"))
        name = NAMES.get(quantity, quantity.replace("_", " "))
        rows.append([name, len(part), median, bound, f"{part['within'].mean():.2f}"])
    columns = ["Statistic", "Values", "Median error", "Bound", "Share within"]
    return pd.DataFrame(rows, columns=columns)


def result(intervals):
    """The result in words: fused ODS with PHY's scenes and without, and whether a gain is shown."""
    of_fuse = fused_ods(intervals)
    added, base = (of_fuse.loc[name] for name in ADDED)
    text = (
        f"Trackers trained on annotated and PHY's scenes ({NAMES[ADDED[0]]}) have a fused ODS of "
        f"{added['mean']:.3f} on the {added['n_images']:.0f} test scenes, trackers trained on "
        f"annotated scenes alone ({NAMES[ADDED[1]]}) {base['mean']:.3f}. The difference is "
        f"{difference(added)}, with its 95 % interval over test scenes"
    )
    if added["difference_low"] > 0:
        return f"{text}: with PHY's scenes, the trackers of this run are better."
    if added["difference_high"] < 0:
        return f"{text}: with PHY's scenes, the trackers of this run are worse."
    return f"{text}, which includes zero: no gain is shown."


def equal_control(intervals, equal):
    """The control in words: RD trained with as many gradients as the set that has most."""
    if equal is None:
        return None
    base = fused_ods(intervals).loc["rd", "mean"]
    longer, added = equal.set_index("output").loc[FUSED, ["rd_ods", "rd_pd_ods"]]
    return (
        "The first control is RD trained with as many gradients as the set with most: its fused "
        f"ODS is {longer:.3f} (with its own number {base:.3f}), and that of {NAMES['rd_pd']} with "
        f"as many is {added:.3f}."
    )


def fused_ods(intervals):
    """Rows of ODS of the fused output, by training set."""
    return intervals.query("output == @FUSED and metric == 'ods'").set_index("training_set")


def over_flights(worth):
    """Table of the result and its controls over the flights of the study, as texts."""
    rows = []
    tested = worth.query("metric == 'ods' and role in ('endpoint', 'secondary')")
    for row in tested.itertuples():
        pair = f"{studied_set(row.training_set).about} less {studied_set(row.base).about}"
        rows.append([pair, row.role, signed(row.mean, row.low, row.high)])
    return pd.DataFrame(rows, columns=["Training sets", "Test", "Fused ODS, mean over flights"])


def summary(table2, jobs, warned):
    """What else a reader looks for first, (name, value, note): similarity, time, warnings."""
    ssim = mean_by_method(table2, "ssim", ".2f")
    psnr = mean_by_method(table2, "psnr", ".1f")
    n_warned = int(warned["Jobs"].sum())
    note = "listed under What ran" if n_warned else "no job warned of anything"
    return [
        ("SSIM with observed scenes", ssim, f"PSNR [dB] {psnr}; means over test scenes"),
        ("Time of all jobs", duration(jobs["s"].sum()), f"{len(jobs)} jobs, a core each"),
        ("Warnings of jobs", str(n_warned), note),
    ]


def mean_by_method(table2, metric, form):
    """Mean of a metric by every method, as "cGAN 0.1, PHY 0.2"."""
    means = table2.query("metric == @metric and statistic == 'mean'").iloc[0]
    return ", ".join(f"{NAMES[method]} {means[method]:{form}}" for method in METHODS)


def read_benchmarks(folder, stages):
    """Snakemake's benchmarks in ``folder/rule/...``, a row a job with its `rule` and `stage`.

    `stages` maps rule to stage; jobs of other rules are left out.
    """
    rows = []
    for path in sorted(Path(folder).rglob("*.tsv")):
        rule = path.relative_to(folder).parts[0]
        measured = pd.read_csv(path, sep="\t", na_values="-")
        rows += measured.assign(rule=rule, stage=stages.get(rule)).to_dict("records")
    jobs = pd.DataFrame(rows, columns=["stage", "rule", "s", "max_rss"])
    return jobs.dropna(subset="stage")


def read_warnings(folder, rules):
    """Table of what jobs of `rules` warned of in their logs, ``folder/rule...``, as texts."""
    found = []
    for path in sorted(Path(folder).rglob("*.log")):
        rule = path.relative_to(folder).with_suffix("").parts[0]
        for line in path.read_text(encoding="utf-8").splitlines() if rule in rules else []:
            if text := WARNED.match(line):
                found.append((rule, text[1], str(path)))
    lines = pd.DataFrame(found, columns=["Rule", "Warning", "Jobs"]).drop_duplicates()
    return lines.groupby(["Rule", "Warning"], sort=False)["Jobs"].size().reset_index()


def costs(jobs, of):
    """Table of the cost of jobs by `stage` or `rule`, the longest first, as texts.

    Snakemake records no memory of jobs that end before it first looks. Its CPU time lacks the last
    half minute of a job: the cost is the time for which a job holds its core.
    """
    grouped = jobs.groupby(of)
    wall_s = grouped["s"].sum().sort_values(ascending=False)
    names = wall_s.index.map(heading) if of == "stage" else wall_s.index
    memory_gb = grouped["max_rss"].max() / GIBIBYTE_MB
    columns = {
        "Jobs": grouped.size(),
        "Wall time": wall_s.map(duration),
        "Share": (wall_s / wall_s.sum()).map("{:.0%}".format),
        "Largest job": memory_gb.map("{:.1f} GiB".format, na_action="ignore").fillna(""),
    }
    table = pd.DataFrame(columns).loc[wall_s.index]
    table.insert(0, of.capitalize(), names)
    return table


def settings_of(config):
    """Table of the settings by their full names, as "section.key"."""
    values = pd.json_normalize(config).iloc[0].astype(str)
    return values.reset_index().set_axis(["Setting", "Value"], axis=1)


def heading(stage):
    """Heading of a stage."""
    return STAGES.get(stage, stage.replace("_", " ").capitalize())


def duration(seconds):
    """Seconds as "45 s", "3 min 20 s" or "2 h 5 min"."""
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {seconds} s"


def figures_by_stage(paths, stages, captions):
    """Figures, lists of dicts by heading of their stage, from three lists of equal length.

    A caption is a sentence on what a figure shows and, after an empty line, one on how to read it.
    """
    by_stage = {}
    for path, stage, caption in zip(paths, stages, captions, strict=True):
        shows, reading = Path(caption).read_text(encoding="utf-8").strip().split("\n\n")
        figure = {"name": Path(path).name, "shows": shows, "reading": reading}
        figure["uri"] = figure_uri(path)
        by_stage.setdefault(heading(stage), []).append(figure)
    return by_stage


def gallery_of(scenes, images, n_scenes=N_SCENES):
    """Test scenes for the gallery, chosen evenly by their number of layers, as dicts.

    `scenes` maps sources to observed and rendered scenes; `images` is the table of similarity.
    """
    scores = images.set_index(["scene", "method"])[["ssim", "psnr"]].astype(float).round(3)
    n_layers = [scene.layer_bins.shape[0] for scene in scenes["observed"]]
    gallery = []
    for number in evenly_spaced(n_layers, n_scenes).tolist():
        scene = scenes["observed"][number]
        shown = {
            "name": scene.name,
            "n_range_bins": scene.n_range_bins,
            "n_range_lines": scene.n_range_lines,
            "n_layers": n_layers[number] - 1,
            "layers": layer_lines(scene.layer_bins),
            "images": {source: image_uri(of[number].image) for source, of in scenes.items()},
            "scores": {method: scores.loc[(scene.name, method)].to_dict() for method in METHODS},
        }
        gallery.append(shown)
    return gallery


def layer_lines(layer_bins, step=LINE_STEP):
    """Layers (layer, range_line) as lists of unbroken pieces [range_line, range_bin, ...].

    Every `step`-th range line is kept, and the last one.
    """
    layer_bins = np.asarray(layer_bins, dtype=float)
    last = layer_bins.shape[1] - 1
    lines = np.union1d(np.arange(0, last, step), last)
    layers = []
    for bins in layer_bins[:, lines]:
        points = np.column_stack([lines, np.round(bins, 1)])
        runs = np.ma.clump_unmasked(np.ma.masked_invalid(bins))
        layers.append([points[run].ravel().tolist() for run in runs])
    return layers


def depth_scale(bin_size_s, snow_density_kg_m3):
    """Delay of a range bin [s], and its thickness in snow of some density and in air [m]."""
    return {
        "snow_density_kg_m3": snow_density_kg_m3,
        "bin_size_s": bin_size_s,
        "snow_per_bin_m": snow_per_bin_m(bin_size_s, snow_density_kg_m3),
        "air_per_bin_m": snow_per_bin_m(bin_size_s, 0),
    }


def figure_uri(path, most_bytes=MOST_BYTES):
    """A figure as a data URI: the file itself or, if that is too large, its PNG as WebP."""
    path = Path(path)
    if path.stat().st_size <= most_bytes:
        return data_uri(path.read_bytes(), MEDIA_TYPES[path.suffix])
    with Image.open(path.with_suffix(".png")) as image:
        return webp_uri(image.convert("RGB"), quality=80)


def image_uri(image):
    """An 8-bit grey image, (row, column), as a WebP data URI; lossy, for looking at."""
    return webp_uri(Image.fromarray(image), quality=65)


def webp_uri(image, quality):
    """A picture as a WebP data URI."""
    content = io.BytesIO()
    image.save(content, format="WEBP", method=4, quality=quality)
    return data_uri(content.getvalue(), "image/webp")


def data_uri(content, media_type):
    """Bytes as a base64 data URI of a media type."""
    text = base64.b64encode(content).decode("ascii")
    return f"data:{media_type};base64,{text}"


def write_page(path, template, content):
    """Write a page from a template, whole or not at all; an undefined name is an error."""
    template = Path(template)
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(template.parent),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    page = environment.get_template(template.name).render(content)
    with written_whole(path) as aside:
        aside.write_text(page, encoding="utf-8")
