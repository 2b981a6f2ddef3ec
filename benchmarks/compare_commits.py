"""Speeds of two commits side by side: ``make compare BASE=v0.5.0``.

``python benchmarks/compare_commits.py BASE [OTHER]`` checks both commits out into a temporary
folder (OTHER is HEAD by default), runs each task of `TASKS` on both in turn, so that a machine that
gets slower meanwhile slows both, and prints the fastest run of each in milliseconds of processor
time of one thread. Tasks call the public interface alone, so that old commits can run them; a task
that a commit cannot run is named. The exit code is 1 if a task became slower by more than
``--slower``, 1.15, in every round.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import click
import numpy as np
import pandas as pd

ROOT = Path(__file__).resolve().parents[1]
BEST_OF = 3  # runs of a task in one process, after one that compiles


def phy_scene():
    """PHY's render of 15 layers on 256 x 256 pixels."""
    from snowsim.phy import render

    layer_bins = np.linspace(50, 220, 15)[:, None] + np.zeros(256)
    shapes = {"peak_power": np.geomspace(1, 0.01, 15), "variance_bins2": np.full(15, 12.0)}
    parameters = {**shapes, "decay_rate": np.full(15, 0.07), "noise_power": 1e-3, "n_looks": 16}
    return lambda: render(layer_bins, parameters, 256, rng=np.random.default_rng(1))


def twenty_scenes():
    """Twenty scenes drawn and rendered from the reference flight's statistics."""
    import snowsim

    return lambda: list(snowsim.scenes(20, rng=1, n_range_bins=400))


def edge_counts():
    """Edge scores of one map at 99 thresholds."""
    from snowsim.metrics.edges import THRESHOLDS, match_counts, suppress

    rng = np.random.default_rng(1)
    truth = np.zeros((300, 256), bool)
    truth[20::25] = True
    found = (truth + 0.3 * rng.random(truth.shape)).astype(np.float32) / 1.3
    return lambda: match_counts(suppress(found), truth, THRESHOLDS)


def simulated():
    """Echogram and layers of annual snow, 512 range lines."""
    import snowsim

    snow = snowsim.Climate(accumulation_m=0.4, n_years=12)
    return snowsim.simulate(snow, "snow-2012", n_range_lines=512, rng=1)


def simulation():
    """`snowsim.simulate` of 512 range lines."""
    return simulated


def flight_statistics():
    """Statistics of one frame of 512 range lines."""
    from snowsim.statistics import fit

    frames = [simulated()]
    return lambda: fit(frames)


def picks():
    """Picks of the package's tracker, 512 range lines."""
    import snowsim

    tracker = snowsim.Tracker.from_pretrained("universal")
    echogram, _ = simulated()
    return lambda: tracker.pick(echogram)


def accumulation():
    """Accumulation of twelve annual layers, 512 range lines."""
    import snowsim

    _, layers = simulated()
    return lambda: snowsim.accumulation(layers)


TASKS = (phy_scene, twenty_scenes, edge_counts, simulation, flight_statistics, picks, accumulation)


def time_tasks():
    """Processor seconds of every task by name, fastest of some; None if it cannot be run."""
    warnings.simplefilter("ignore")
    seconds = {}
    for task in TASKS:
        try:
            work = task()
            work()  # compiles
            runs = []
            for _ in range(BEST_OF):
                start = time.process_time()
                work()
                runs.append(time.process_time() - start)
            seconds[task.__name__] = min(runs)
        except Exception:  # of whatever kind: this commit does not have what the task calls
            seconds[task.__name__] = None
    return seconds


def time_commit(checkout):
    """`time_tasks` in a process of its own that imports snowsim from a checkout."""
    # One thread: threads of libraries share their time in ways that no commit changes.
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
    environment = os.environ | one | {"PYTHONPATH": str(checkout)}
    command = [sys.executable, __file__, "--tasks"]
    run = subprocess.run(command, env=environment, cwd=checkout, capture_output=True, text=True)
    if run.returncode:
        msg = f"{checkout.name} does not run: {run.stderr[-500:]}"
        raise click.ClickException(msg)
    return json.loads(run.stdout.splitlines()[-1])


def compared(rounds, slower):
    """Table of tasks: fastest of both commits [ms], their ratio, and what that says.

    `rounds` are pairs of what `time_commit` gives for both. A task counts as slower, or faster, if
    its ratio is beyond `slower` in every round: one round may meet another job.
    """
    rows = []
    for task in rounds[0][0]:
        pairs = np.array([[base[task], other[task]] for base, other in rounds], dtype=float)
        base_s, other_s = pairs.min(axis=0)
        ratios = pairs[:, 1] / pairs[:, 0]
        verdict = "not run" if np.isnan(pairs).any() else "same"
        if (ratios > slower).all():
            verdict = "slower"
        elif (ratios < 1 / slower).all():
            verdict = "faster"
        rows.append([task, 1e3 * base_s, 1e3 * other_s, other_s / base_s, verdict])
    return pd.DataFrame(rows, columns=["task", "base_ms", "other_ms", "ratio", "verdict"])


@click.command()
@click.argument("base", required=False)
@click.argument("other", default="HEAD")
@click.option("--rounds", "n_rounds", type=click.IntRange(1), default=3, show_default=True)
@click.option("--slower", type=click.FloatRange(1), default=1.15, show_default=True)
@click.option("--tasks", is_flag=True, hidden=True, help="Time this process's own snowsim.")
def main(base, other, n_rounds, slower, tasks):
    """Compare the speeds of commit OTHER with those of BASE."""
    if tasks:
        click.echo(json.dumps(time_tasks()))
        return
    if base is None:
        msg = "name a commit to compare with, such as HEAD~1"
        raise click.UsageError(msg)
    with tempfile.TemporaryDirectory() as folder:
        checkouts = [Path(folder) / name for name in ("base", "other")]
        for checkout, commit in zip(checkouts, (base, other), strict=True):
            tree = subprocess.run(
                ["git", "archive", commit], cwd=ROOT, capture_output=True, check=False
            )
            if tree.returncode:
                msg = f"{commit}: {tree.stderr.decode().strip()}"
                raise click.ClickException(msg)
            checkout.mkdir()
            subprocess.run(["tar", "-x"], input=tree.stdout, cwd=checkout, check=True)
        rounds = [tuple(map(time_commit, checkouts)) for _ in range(n_rounds)]
    table = compared(rounds, slower)
    click.echo(table.round(2).to_string(index=False))
    sys.exit(int((table["verdict"] == "slower").any()))


if __name__ == "__main__":
    main()
