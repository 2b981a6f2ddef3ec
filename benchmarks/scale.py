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
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import yaml

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "workflow"))

from lib.configuration import filled  # noqa: E402

SNAKEMAKE = Path(sys.executable).with_name("snakemake")
MEASURED = (1500, 15_000)  # label sets
PROJECTED = 150_000
# An assumption, for no total is published: ten years with two campaigns of about 75,000 km each.
ARCHIVE_KM = 1_500_000
CORES = 1000


@dataclass(frozen=True)
class Job:
    """A finished job of a run."""

    rule: str
    seconds: float  # from start to end
    work_s: float  # of it, its script
    memory_mb: float


@dataclass(frozen=True)
class Stage:
    """A rule with its work: so many units, in these files."""

    rule: str
    n_units: int
    unit: str
    files: str


@dataclass(frozen=True)
class Cost:
    """What a stage takes; bytes and seconds of work are per unit."""

    stage: Stage
    seconds: float
    bytes: float
    start_s: float  # of a job, with its end
    memory_mb: float


@dataclass(frozen=True)
class Call:
    """A finished call of Snakemake."""

    wall_s: float
    cpu_s: float
    memory_mb: float
    output: str


def read_jobs(run):
    """All jobs of a run that were measured."""
    jobs = []
    folder = run / "results/benchmarks"
    for path in sorted(folder.rglob("*.tsv")):
        name = path.relative_to(folder).with_suffix("")
        rule = name.parts[0]
        log = run / "logs" / f"{name}.log"
        if not log.exists():
            log = run / "logs" / f"{rule}.log"
        with path.open() as file:
            row = next(csv.DictReader(file, delimiter="\t"))
        work = re.search(r"done in ([\d.]+) s", log.read_text())
        memory = row["max_rss"]
        memory_mb = 0.0 if memory in ("-", "NA") else float(memory)
        jobs.append(Job(rule, float(row["s"]), float(work[1]), memory_mb))
    return jobs


def late_imports(run, jobs):
    """Seconds of imports inside functions, which the log of a job counts as work."""
    path = run / "logs/imports.tsv"
    if not path.exists():
        msg = f"{path}: expected a row a job, the file is not there: "
        msg += "PYTHONPATH=benchmarks/import_clock make run"
        raise ValueError(msg)
    lines = path.read_text().splitlines()
    if len(lines) != len(jobs):
        msg = f"{path}: expected a row for each of {len(jobs)} jobs, found {len(lines)}"
        raise ValueError(msg)
    rows = [line.split("\t") for line in lines]
    life_s = sum(float(life) for life, _ in rows)
    imports_s = sum(float(imports) for _, imports in rows)
    # All imports but those before the work of a job.
    return imports_s - (life_s - sum(job.work_s for job in jobs))


def size_of(run, pattern):
    """Bytes of all files that match a pattern under results/."""
    return sum(path.stat().st_size for path in (run / "results").glob(pattern))


def idle_seconds(run):
    """Core seconds of the longest logged run without a job: planning, waiting for other jobs."""
    logs = [path.read_text() for path in (run / ".snakemake/log").glob("*.log")]
    log = max(logs, key=lambda text: text.count("Finished jobid"))
    cores = int(re.search(r"Provided cores: (\d+)", log)[1])
    hours, minutes, seconds = re.search(r"Elapsed time: (\d+):(\d+):([\d.]+)", log).groups()
    elapsed = 3600 * int(hours) + 60 * int(minutes) + float(seconds)
    return cores * elapsed - sum(job.seconds for job in read_jobs(run))


def stages(config):
    """The stages by name."""
    n = config["benchmark"]["n_scenes"]
    n_frames = config["flight"]["n_frames"]
    n_labels = config["labels"]["n_scenes"]
    n_rendered = n_labels + n["test"]
    n_trackers = 4 * config["tracker"]["n_seeds"]
    cgan_steps = config["cgan"]["training"]["n_steps"]
    tracker_steps = n_trackers * config["tracker"]["training"]["n_steps"]
    frame = f"frame of {config['flight']['n_range_lines']} lines"
    return {
        "flight": Stage("reference_frames", n_frames, frame, "flight/[0-9]*.nc"),
        "benchmark": Stage("reference_scenes", sum(n.values()), "scene", "benchmark/**/*.nc"),
        "statistics": Stage("summarise_frames", n_frames, frame, "statistics/*.nc"),
        "labels": Stage("draw_labels", n_labels, "scene", "labels/*.nc"),
        "PHY": Stage("render_phy", n_rendered, "scene", "phy/*/*.nc"),
        "cGAN training": Stage("train_cgan", cgan_steps, "step", "cgan/*.safetensors"),
        "cGAN": Stage("render_cgan", n_rendered, "scene", "cgan/*/*.nc"),
        "similarity": Stage("score_similarity", 2 * n["test"], "scene", "similarity/**/*.parquet"),
        "tracker training": Stage(
            "train_tracker", tracker_steps, "step", "tracker/*/*.safetensors"
        ),
        "tracking, scores": Stage(
            "score_tracker", n_trackers * n["test"], "scene", "tracker/*/*.parquet"
        ),
    }


def costs_of(run, config):
    """Costs of the stages by name."""
    return {name: cost_of(run, stage) for name, stage in stages(config).items()}


def cost_of(run, stage):
    """Cost of one stage."""
    own = [job for job in read_jobs(run) if job.rule == stage.rule]
    work_s = sum(job.work_s for job in own)
    whole_s = sum(job.seconds for job in own)
    return Cost(
        stage,
        seconds=work_s / stage.n_units,
        bytes=size_of(run, stage.files) / stage.n_units,
        start_s=(whole_s - work_s) / len(own),
        memory_mb=max(job.memory_mb for job in own),
    )


def cost_of_picks(run):
    """Cost of the layers of all frames of a run's flight, tracked without annotation."""
    frames = sorted((run / "results/flight").glob("[0-9][0-9][0-9][0-9].nc"))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        rows = [f"{path.stem}\t{path}\t\ttrack" for path in frames]
        table = folder / "frames.tsv"
        table.write_text("\n".join(["frame\techogram\tlayers\trole", *rows]))
        call(folder, {"import": {"frames": str(table)}}, "--", "picks")
        stage = Stage("track_frames", len(frames), "frame", "picks/**/*.*")
        return cost_of(folder, stage)


def call(folder, settings, *arguments):
    """Run Snakemake with some settings."""
    override = folder / "settings.yaml"
    override.write_text(yaml.safe_dump(settings))
    words = [SNAKEMAKE, "--cores", 1, "--directory", folder]
    words += ["--configfile", ROOT / "config/config.yaml", override, *arguments]
    words = [str(word) for word in words]
    with tempfile.TemporaryFile("w+") as output:
        begin = time.perf_counter()
        process = subprocess.Popen(words, stdout=output, stderr=subprocess.STDOUT, cwd=ROOT)
        _, status, used = os.wait4(process.pid, 0)
        wall_s = time.perf_counter() - begin
        output.seek(0)
        text = output.read()
    if status != 0:
        raise RuntimeError(text[-2000:])
    return Call(wall_s, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, text)


def measure(run, n_scenes):
    """Plan the workflow for a number of label sets, and draw these from a run's statistics."""
    settings = {"labels": {"n_scenes": n_scenes}}
    with tempfile.TemporaryDirectory() as folder:
        plan = call(Path(folder), settings, "--dry-run")
    n_jobs = re.search(r"^total\s+(\d+)$", plan.output, flags=re.MULTILINE)[1]
    files = [f"results/labels/{shard:04d}.nc" for shard in range(-(-n_scenes // shard_size()))]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "results").mkdir()
        shutil.copy2(run / "results/statistics.nc", folder / "results")
        done = call(folder, settings, "--allowed-rules", "draw_labels", "--", *files)
        inside_s = sum(job.seconds for job in read_jobs(folder))
        n_bytes = size_of(folder, "labels/*.nc")
    return pd.Series(
        {
            "jobs": int(n_jobs),
            "plan_s": plan.cpu_s,
            "plan_memory_mb": plan.memory_mb,
            "bytes": n_bytes,
            "outside": 1 - inside_s / done.wall_s,
            "draws": len(files),
        }
    )


def default_config():
    return filled(yaml.safe_load((ROOT / "config/config.yaml").read_text()))


def shard_size():
    return default_config()["labels"]["shard_size"]


def write(run):
    """The page as lines of Markdown."""
    config = default_config()
    costs = costs_of(run, config)
    yield "# Scale"
    yield ""
    yield "Made by `benchmarks/scale.py` from a finished default run, one core a job."
    yield ""
    yield from write_costs(run, costs)
    yield from write_label_sets(run, costs)
    yield from write_archive(config, costs, cost_of_picks(run))


def write_costs(run, costs):
    """What a unit of each stage takes, and what jobs take beside their work."""
    yield "## Cost of a stage"
    yield ""
    yield ("| stage | units | s per unit | kB per unit | s to start a job | memory of a job [MB] |")
    yield "|---|---|---|---|---|---|"
    for name, cost in costs.items():
        units = f"{cost.stage.n_units} x {cost.stage.unit}"
        of_unit = f"{cost.seconds:.4f} | {cost.bytes / 1e3:.1f}"
        yield f"| {name} | {units} | {of_unit} | {cost.start_s:.1f} | {cost.memory_mb:.0f} |"
    jobs = read_jobs(run)
    n_jobs = len(jobs)
    whole = sum(job.seconds for job in jobs)
    start = whole - sum(job.work_s for job in jobs)
    late = late_imports(run, jobs)
    idle = idle_seconds(run)
    share = (start + late + idle) / (whole + idle)
    yield ""
    yield (
        f"Of {whole:.0f} s in {n_jobs} jobs, {start:.0f} s start and end Python and import what "
        "the job needs;"
    )
    yield (
        f"imports inside functions, which the table counts as work, take {late:.0f} s more. Beside "
        "the jobs, cores"
    )
    yield (
        f"waited {idle:.0f} s for Snakemake or for other jobs, {idle / n_jobs:.2f} s per job. "
        "Together these are"
    )
    yield f"{share:.1%} of the time of all cores."
    yield ""


def write_label_sets(run, costs):
    """What many label sets take, and a projection."""
    yield "## Many label sets"
    yield ""
    columns = [
        "label sets",
        "jobs",
        "plan, CPU [s]",
        "memory of Snakemake [MB]",
        "labels [MB]",
        "scenes of both methods [GB]",
        "PHY [core h]",
        "cGAN [core h]",
        "Snakemake's share of a labels run",
    ]
    yield "| " + " | ".join(columns) + " |"
    yield "|---" * len(columns) + "|"
    few, many = (measure(run, n) for n in MEASURED)
    per_set = (many - few) / (MEASURED[1] - MEASURED[0])
    far = few + (PROJECTED - MEASURED[0]) * per_set
    phy = costs["PHY"]
    cgan = costs["cGAN"]
    for n, sets in zip((*MEASURED, PROJECTED), (few, many, far), strict=True):
        plan = f"{sets.jobs:.0f} | {sets.plan_s:.1f} | {sets.plan_memory_mb:.0f}"
        sizes = f"{sets.bytes / 1e6:.0f} | {n * (phy.bytes + cgan.bytes) / 1e9:.2f}"
        hours = f"{n * phy.seconds / 3600:.2f} | {n * cgan.seconds / 3600:.2f}"
        drawn = f"{sets.outside:.0%}, {sets.draws:.0f} jobs" if n < PROJECTED else "projected"
        yield f"| {n} | {plan} | {sizes} | {hours} | {drawn} |"
    yield ""
    yield (
        f"Shards hold {shard_size()} scenes; `labels.shard_size` sets it. The last row is a "
        "straight line through"
    )
    yield (
        "the other two. A job's memory does not grow with the number of scenes: one is held at a "
        "time."
    )


def write_archive(config, costs, picks):
    """What statistics and tracking of all of IceBridge would take."""
    n_lines = ARCHIVE_KM * 1000 / config["reference"]["radar"]["line_spacing_m"]
    frame_lines = config["flight"]["n_range_lines"]
    n_frames = n_lines / frame_lines
    n_scenes = n_lines / config["labels"]["n_range_lines"]
    yield ""
    yield "## The whole IceBridge archive"
    yield ""
    yield (
        f"Assumed: {ARCHIVE_KM:,} km of track; all is proportional to it. At "
        f"{n_lines / ARCHIVE_KM:.0f} lines per km these are"
    )
    yield f"{n_frames:,.0f} frames of {frame_lines} lines or {n_scenes:,.0f} scenes of 256."
    yield f"On {CORES} cores, jobs of 100 frames or 1000 scenes:"
    yield ""
    yield f"| stage | core h | min on {CORES} cores | jobs | files [GB] |"
    yield "|---|---|---|---|---|"
    yield archive_row("statistics", costs["statistics"], n_frames, n_frames / 100)
    yield archive_row("layers without annotation, `picks`", picks, n_frames, n_frames / 100)
    for name, stage in {
        "PHY render of every scene": "PHY",
        "cGAN render of every scene, CPU": "cGAN",
        "tracking and edge scores, CPU": "tracking, scores",
    }.items():
        yield archive_row(name, costs[stage], n_scenes, n_scenes / 1000)
    yield ""
    yield (
        f"Reading the archive is not in these numbers: {n_lines * 1000 * 4 / 1e12:.1f} TB at 1000 "
        "bins a line and 4 bytes a pixel."
    )


def archive_row(name, cost, n_units, n_jobs):
    """One stage of the whole archive."""
    hours = (n_units * cost.seconds + n_jobs * cost.start_s) / 3600
    minutes = hours / CORES * 60
    gigabytes = n_units * cost.bytes / 1e9
    return f"| {name} | {hours:,.0f} | {minutes:.1f} | {n_jobs:,.0f} | {gigabytes:,.1f} |"


if __name__ == "__main__":
    for text in write(Path(sys.argv[1]).resolve()):
        sys.stdout.write(text + "\n")
