"""What the workflow costs per scene, and what it takes to plan and run many.

``python benchmarks/scale.py RUN > docs/scale.md``, where RUN is the folder of a finished default
run (with results/ and logs/), made in a fresh clone by ``PYTHONPATH=benchmarks/import_clock make
run``. Plans and label sets of 1500 and 15,000 scenes are made anew in a temporary folder; 150,000
are projected.
"""

import csv
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[1]
SNAKEMAKE = Path(sys.executable).with_name("snakemake")
MEASURED, PROJECTED = (1500, 15_000), 150_000
# An assumption, for no total is published: ten years with two campaigns of about 75,000 km each.
ARCHIVE_KM = 1_500_000
CORES = 1000


def read_benchmarks(run):
    """Rows of all benchmark files: rule, seconds from start to end, seconds of work, memory [MB]."""
    rows = []
    for path in sorted((run / "results/benchmarks").rglob("*.tsv")):
        name = path.relative_to(run / "results/benchmarks").with_suffix("")
        log = run / "logs" / f"{name}.log"
        log = log if log.exists() else run / "logs" / f"{name.parts[0]}.log"
        with path.open() as file:
            row = next(csv.DictReader(file, delimiter="\t"))
        work = re.search(r"done in ([\d.]+) s", log.read_text())
        memory = 0.0 if row["max_rss"] in ("-", "NA") else float(row["max_rss"])
        rows.append((name.parts[0], float(row["s"]), float(work[1]), memory))
    return rows


def late_imports(run, rows):
    """Seconds of imports inside functions, which the log of a job counts as work: all but those before its work."""
    path = run / "logs/imports.tsv"
    if not path.exists():
        msg = f"{path}: expected a row a job, the file is not there: PYTHONPATH=benchmarks/import_clock make run"
        raise ValueError(msg)
    lines = path.read_text().splitlines()
    if len(lines) != len(rows):
        msg = f"{path}: expected a row for each of {len(rows)} jobs, found {len(lines)}"
        raise ValueError(msg)
    life, imports = (
        sum(column)
        for column in zip(*(map(float, line.split("\t")) for line in lines), strict=True)
    )
    return imports - (life - sum(row[2] for row in rows))


def size_of(run, pattern):
    """Bytes of all files that match a pattern under results/."""
    return sum(path.stat().st_size for path in (run / "results").glob(pattern))


def idle_seconds(run):
    """Core seconds of the longest logged run in which no job ran: planning, scheduling, waiting for others."""
    logs = [path.read_text() for path in (run / ".snakemake/log").glob("*.log")]
    log = max(logs, key=lambda text: text.count("Finished jobid"))
    cores = int(re.search(r"Provided cores: (\d+)", log)[1])
    hours, minutes, seconds = re.search(r"Elapsed time: (\d+):(\d+):([\d.]+)", log).groups()
    elapsed = 3600 * int(hours) + 60 * int(minutes) + float(seconds)
    return cores * elapsed - sum(row[1] for row in read_benchmarks(run))


def stages(config):
    """Stage: rule, how many units of work, what a unit is, its files."""
    n = config["benchmark"]["n_scenes"]
    n_labels = config["labels"]["n_scenes"]
    n_trackers = 4 * config["tracker"]["n_seeds"]
    lines = config["flight"]["n_range_lines"]
    frame, rendered = f"frame of {lines} lines", n_labels + n["test"]
    return {
        "flight": ("reference_frames", config["flight"]["n_frames"], frame, "flight/[0-9]*.nc"),
        "benchmark": ("reference_scenes", sum(n.values()), "scene", "benchmark/**/*.nc"),
        "statistics": ("summarise_frames", config["flight"]["n_frames"], frame, "statistics/*.nc"),
        "labels": ("draw_labels", n_labels, "scene", "labels/*.nc"),
        "PHY": ("render_phy", rendered, "scene", "phy/*/*.nc"),
        "cGAN training": ("train_cgan", config["cgan"]["training"]["n_steps"], "step", "cgan/*.safetensors"),
        "cGAN": ("render_cgan", rendered, "scene", "cgan/*/*.nc"),
        "similarity": ("score_similarity", 2 * n["test"], "scene", "similarity/**/*.parquet"),
        "tracker training": (
            "train_tracker", n_trackers * config["tracker"]["training"]["n_steps"], "step", "tracker/*/*.safetensors",
        ),
        "tracking, scores": ("score_tracker", n_trackers * n["test"], "scene", "tracker/*/*.parquet"),
    }  # fmt: skip


def cost_table(run, config):
    """Per stage: (units, unit, seconds of work per unit, bytes per unit, seconds to start a job, memory)."""
    rows = read_benchmarks(run)
    table = {}
    for stage, (rule, n, unit, pattern) in stages(config).items():
        mine = [row for row in rows if row[0] == rule]
        work, whole = sum(row[2] for row in mine), sum(row[1] for row in mine)
        start = (whole - work) / len(mine)
        table[stage] = (
            n,
            unit,
            work / n,
            size_of(run, pattern) / n,
            start,
            max(row[3] for row in mine),
        )
    return table


def call(folder, n_scenes, *arguments):
    """Run Snakemake for a number of label sets: (wall seconds, seconds of CPU, largest memory [MB], output)."""
    override = folder / f"{n_scenes}.yaml"
    override.write_text(f"labels: {{n_scenes: {n_scenes}}}\n")
    words = [SNAKEMAKE, "--cores", 1, "--directory", folder]
    words += ["--configfile", ROOT / "config/config.yaml", override, *arguments]
    with tempfile.TemporaryFile("w+") as output:
        begin = time.perf_counter()
        process = subprocess.Popen(
            list(map(str, words)), stdout=output, stderr=subprocess.STDOUT, cwd=ROOT
        )
        _, status, used = os.wait4(process.pid, 0)
        wall = time.perf_counter() - begin
        output.seek(0)
        text = output.read()
    if status != 0:
        raise RuntimeError(text[-2000:])
    return wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, text


def measure_plan(n_scenes):
    """Plan the whole workflow: (jobs, CPU s, memory of Snakemake [MB])."""
    with tempfile.TemporaryDirectory() as folder:
        _, *used, output = call(Path(folder), n_scenes, "--dry-run")
        return int(re.search(r"^total\s+(\d+)$", output, flags=re.MULTILINE)[1]), *used


def measure_labels(run, n_scenes):
    """Draw all label sets from a finished run's statistics: (jobs, share of time outside them, bytes)."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "results").mkdir()
        shutil.copy2(run / "results/statistics.nc", folder / "results")
        shards = [f"results/labels/{shard:04d}.nc" for shard in range(-(-n_scenes // shard_size()))]
        wall, *_ = call(folder, n_scenes, "--allowed-rules", "draw_labels", "--", *shards)
        inside = sum(row[1] for row in read_benchmarks(folder))
        return len(shards), 1 - inside / wall, size_of(folder, "labels/*.nc")


def default_config():
    return yaml.safe_load((ROOT / "config/config.yaml").read_text())


def shard_size():
    return default_config()["labels"]["shard_size"]


def line_through(points, at):
    """Value at `at` of the straight line through two points."""
    (a, y_a), (b, y_b) = points
    return y_a + (y_b - y_a) / (b - a) * (at - a)


def write(run):
    """The page as lines of Markdown."""
    config = default_config()
    costs = cost_table(run, config)
    yield from (
        "# Scale",
        "",
        "Made by `benchmarks/scale.py` from a finished default run, one core a job.",
        "",
    )
    yield from ("## Cost of a stage", "")
    yield "| stage | units | s per unit | kB per unit | s to start a job | memory of a job [MB] |"
    yield "|---|---|---|---|---|---|"
    for stage, (n, unit, seconds, size, start, memory) in costs.items():
        yield f"| {stage} | {n} x {unit} | {seconds:.4f} | {size / 1e3:.1f} | {start:.1f} | {memory:.0f} |"
    rows = read_benchmarks(run)
    whole, work = sum(row[1] for row in rows), sum(row[2] for row in rows)
    start, late, idle = whole - work, late_imports(run, rows), idle_seconds(run)
    yield from (
        "",
        f"Of {whole:.0f} s in {len(rows)} jobs, {start:.0f} s start and end Python and import what the job needs;",
    )
    yield f"imports inside functions, which the table counts as work, take {late:.0f} s more. Beside the jobs, cores"
    yield f"waited {idle:.0f} s for Snakemake or for other jobs, {idle / len(rows):.2f} s per job. Together these are"
    yield f"{(start + late + idle) / (whole + idle):.1%} of the time of all cores."
    yield from ("", "## Many label sets", "")
    columns = (
        "label sets", "jobs", "plan, CPU [s]", "memory of Snakemake [MB]", "labels [MB]",
        "scenes of both methods [GB]", "PHY [core h]", "cGAN [core h]", "Snakemake's share of a labels run",
    )  # fmt: skip
    yield "| " + " | ".join(columns) + " |"
    yield "|---" * len(columns) + "|"
    plans = {n: measure_plan(n) for n in MEASURED}
    drawn = {n: measure_labels(run, n) for n in MEASURED}
    lines = []
    for n in (*MEASURED, PROJECTED):
        if n in plans:
            jobs, cpu, memory = plans[n]
            size, share = drawn[n][2], f"{drawn[n][1]:.0%}, {drawn[n][0]} jobs"
        else:
            jobs, cpu, memory = (
                line_through([(k, plans[k][i]) for k in MEASURED], n) for i in range(3)
            )
            size, share = line_through([(k, drawn[k][2]) for k in MEASURED], n), "projected"
        both = n * (costs["PHY"][3] + costs["cGAN"][3]) / 1e9
        hours = [n * costs[name][2] / 3600 for name in ("PHY", "cGAN")]
        lines.append(
            f"| {n} | {jobs:.0f} | {cpu:.1f} | {memory:.0f} | {size / 1e6:.0f} | {both:.2f} "
            f"| {hours[0]:.2f} | {hours[1]:.2f} | {share} |"
        )
    yield from (*lines, "")
    yield f"Shards hold {shard_size()} scenes; `labels.shard_size` sets it. The last row is a straight line through"
    yield "the other two. A job's memory does not grow with the number of scenes: one is held at a time."
    yield from project_archive(config, costs)


def project_archive(config, costs):
    """What statistics and tracking of all of IceBridge would take."""
    per_km = 1000 / config["reference"]["radar"]["line_spacing_m"]
    n_frames = ARCHIVE_KM * per_km / config["flight"]["n_range_lines"]
    n_scenes = ARCHIVE_KM * per_km / config["labels"]["n_range_lines"]
    yield from ("", "## The whole IceBridge archive", "")
    yield f"Assumed: {ARCHIVE_KM:,} km of track; all is proportional to it. At {per_km:.0f} lines per km these are"
    yield f"{n_frames:,.0f} frames of {config['flight']['n_range_lines']} lines or {n_scenes:,.0f} scenes of 256."
    yield f"On {CORES} cores, jobs of 100 frames or 1000 scenes:"
    yield from (
        "",
        f"| stage | core h | min on {CORES} cores | jobs | files [GB] |",
        "|---|---|---|---|---|",
    )
    for name, stage, n, per_job in (
        ("statistics", "statistics", n_frames, 100),
        ("PHY render of every scene", "PHY", n_scenes, 1000),
        ("cGAN render of every scene, CPU", "cGAN", n_scenes, 1000),
        ("tracking and edge scores, CPU", "tracking, scores", n_scenes, 1000),
    ):
        _, _, seconds, size, start, _ = costs[stage]
        hours = (n * seconds + n / per_job * start) / 3600
        yield f"| {name} | {hours:,.0f} | {hours / CORES * 60:.1f} | {n / per_job:,.0f} | {n * size / 1e9:,.1f} |"
    size = ARCHIVE_KM * per_km * 1000 * 4 / 1e12
    yield from (
        "",
        f"Reading the archive is not in these numbers: {size:.1f} TB at 1000 bins a line and 4 bytes a pixel.",
    )


if __name__ == "__main__":
    for text in write(Path(sys.argv[1]).resolve()):
        sys.stdout.write(text + "\n")
