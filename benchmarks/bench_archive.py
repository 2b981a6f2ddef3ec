"""A small archive through ``snakemake picks`` and SLURM on one machine, jobs killed at random.

``python benchmarks/bench_archive.py FOLDER`` simulates 100 segments of 20 frames of 1,000 range
lines in FOLDER/frames, where they are missing (5.1 GB, ten minutes of a core). It starts a SLURM
cluster of one node and tracks them with the profile `slurm`. Meanwhile it kills the scripts of four
jobs, and interrupts Snakemake when half of the jobs have ended; then Snakemake is started again.
Printed are the wall time with all that, range lines a second, and the largest memory of Snakemake
and of a job. At last the first job's layers are compared with those of an undisturbed run. Needs
what ``make test-machine`` installs.
"""

import filecmp
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import psutil

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / name) for name in ("workflow", "tests", "tests/workflow")]

from slurm import one_node_cluster, scripts_at_work, steps_at_work  # noqa: E402

N_SEGMENTS, N_FRAMES, N_LINES, FRAMES_PER_JOB = 100, 20, 1000, 100
N_KILLED, SEED = 4, 0
ACCUMULATIONS_M = (0.2, 0.3, 0.45, 0.6)
PROGRAMS = Path(sys.executable).parent


def say(line):
    """Write a line at once."""
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def simulate(folder):
    """Simulate the segments that are missing in a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for seed in range(1, N_SEGMENTS + 1):
        day, number = divmod(seed - 1, 20)
        segment = f"2012040{1 + day}_{1 + number:02d}"
        if (folder / f"Data_{segment}_{N_FRAMES:03d}.mat").exists():
            continue
        words = [PROGRAMS / "snowsim", "simulate", f"Data_{segment}_001.mat", "--force"]
        words += ["--radar", "snow-2012", "--frames", N_FRAMES, "--range-lines", N_LINES]
        words += ["--seed", seed, "--accumulation-m", ACCUMULATIONS_M[seed % 4]]
        subprocess.run(list(map(str, words)), cwd=folder, check=True, stdout=subprocess.DEVNULL)


def prepare(folder, frames):
    """A folder for a run on echograms, with its table of frames and its configuration."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    rows = [f"{path.stem.removeprefix('Data_')}\t{path}\t\ttrack\n" for path in frames]
    (folder / "frames.tsv").write_text("".join(["frame\techogram\tlayers\trole\n", *rows]))
    (folder / "config.yaml").write_text(
        f"import: {{frames: frames.tsv}}\nflight: {{frames_per_job: {FRAMES_PER_JOB}}}\n"
    )
    return folder


def started(folder, profile, path, *words):
    """The process of ``snakemake picks`` in a folder, with a profile and a PATH."""
    call = [PROGRAMS / "snakemake", "--snakefile", ROOT / "Snakefile", "--directory", folder]
    call += ["--workflow-profile", ROOT / "profiles" / profile]
    call += ["--configfile", folder / "config.yaml", *words, "--", "picks"]
    with (folder / "snakemake.log").open("a") as log:
        return subprocess.Popen(
            list(map(str, call)), stdout=log, stderr=log, env=os.environ | {"PATH": path}
        )


def memory(processes):
    """Resident memory of processes [bytes], as far as they still run."""
    total = 0
    for each in processes:
        try:
            total += each.memory_info().rss
        except psutil.NoSuchProcess:
            continue
    return total


def disturbed_run(folder, path, n_jobs):
    """Track with jobs killed and Snakemake interrupted once: seconds, and memory [bytes]."""
    rng = random.Random(SEED)
    most = {"Snakemake": 0, "a job": 0}
    kill_when = sorted(rng.sample(range(1, n_jobs - 2), N_KILLED))
    begin = time.monotonic()
    n_started = 1
    head = started(folder, "slurm", path, "--retries", 2)
    while True:
        time.sleep(0.5)
        n_ended = len(list(folder.glob("results/picks/*/frames.csv")))
        if head.poll() is not None:
            if head.returncode == 0:
                return time.monotonic() - begin, most
            if n_started == 2:
                msg = f"Snakemake failed: {folder / 'snakemake.log'}"
                raise RuntimeError(msg)
            head = started(folder, "slurm", path, "--retries", 2)
            n_started = 2
        most["Snakemake"] = max(most["Snakemake"], memory([psutil.Process(head.pid)]))
        most["a job"] = max([most["a job"], *map(memory, steps_at_work())])
        scripts = list(scripts_at_work("track_frames.py"))
        if scripts and kill_when and n_ended >= kill_when[0]:
            rng.choice(scripts).kill()
            say(f"{n_ended} jobs have ended: a script was killed")
            kill_when.pop(0)
        if n_started == 1 and n_ended >= n_jobs // 2:
            head.send_signal(signal.SIGINT)
            head.wait()
            say(f"{n_ended} jobs have ended: Snakemake was interrupted")


def main(folder):
    # A process in the background ignores Ctrl-C, and hands that on to Snakemake.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    frames_folder = folder / "frames"
    simulate(frames_folder)
    frames = sorted(frames_folder.glob("Data_*.mat"))
    run = prepare(folder / "run", frames)
    n_jobs = len(frames) // FRAMES_PER_JOB
    shutil.rmtree(folder / "cluster", ignore_errors=True)
    with one_node_cluster(folder / "cluster") as programs:
        seconds, most = disturbed_run(run, f"{programs}:{os.environ['PATH']}", n_jobs)
    n_lines = len(frames) * N_LINES
    speed = n_lines / seconds
    say(f"{n_jobs} jobs, {n_lines} range lines: {seconds:.0f} s, {speed:.0f} lines a second")
    for name, of_it in most.items():
        say(f"largest memory of {name}: {of_it / 1e6:.0f} MB")
    tables = list(run.glob("results/benchmarks/track_frames/*.tsv"))
    spent = pd.concat(pd.read_csv(path, sep="\t") for path in tables)["s"]
    say(f"a script takes {spent.mean():.0f} s, {n_lines / spent.sum():.0f} lines a second")
    in_files = sum(path.stat().st_size for path in frames)
    out_files = [path for path in run.glob("results/picks/**/*") if path.is_file()]
    of_layers = sum(path.stat().st_size for path in out_files)
    say(f"{in_files / 1e9:.2f} GB in, {of_layers / 1e9:.3f} GB out in {len(out_files)} files")
    undisturbed = prepare(folder / "undisturbed", frames[:FRAMES_PER_JOB])
    if started(undisturbed, "default", os.environ["PATH"], "--cores", 1).wait():
        msg = f"the undisturbed run failed: {undisturbed / 'snakemake.log'}"
        raise RuntimeError(msg)
    (alone,) = (undisturbed / "results/picks").iterdir()
    first = min((run / "results/picks").iterdir())
    files = [path.relative_to(alone) for path in alone.rglob("*") if path.is_file()]
    equal, differing, failed = filecmp.cmpfiles(alone, first, files, shallow=False)
    n_others = len(differing) + len(failed)
    say(f"of the first job's files {len(equal)} equal those of an undisturbed run, {n_others} not")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
