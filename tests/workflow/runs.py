"""Runs of the workflow in folders of their own, from a copy of its source that tests may edit."""

import atexit
import functools
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SNAKEMAKE = Path(sys.executable).with_name("snakemake")
PARTS = ("Snakefile", "workflow", "snowsim", "config", "profiles", "envs")


@functools.cache
def source_tree():
    """Copy of what a run reads, the same for all tests of a session; times of files are kept, edits must be undone."""
    folder = Path(tempfile.mkdtemp(prefix="snowsim_source_"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    for name in PARTS:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy2
        copy(ROOT / name, folder / name)
    return folder


def command(folder, *arguments, configs=("config.yaml", "tiny.yaml"), cores=2, profile="default"):
    """Words of a call of Snakemake with results in `folder`."""
    source = source_tree()
    words = [
        SNAKEMAKE,
        *("--snakefile", source / "Snakefile"),
        *("--directory", folder),
        *("--workflow-profile", source / "profiles" / profile),
        *(("--cores", cores) if profile == "default" else ()),
        *("--configfile", *[source / "config" / config for config in configs]),
        *arguments,
    ]
    return [str(word) for word in words]


def environment(**changes):
    """Environment of a run: the package is the copy's."""
    return {**os.environ, "PYTHONPATH": str(source_tree()), **changes}


def run_snakemake(folder, *arguments, timeout=540, **options):
    """Run the workflow with results in `folder`; gives the finished process with its output as text.

    Options are those of `command`.
    """
    return subprocess.run(
        command(folder, *arguments, **options),
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
        cwd=source_tree(),
        env=environment(),
    )


def rules_to_run(dry_run):
    """Names of the rules in the job table of a dry run, targets that only collect files left out."""
    assert dry_run.returncode == 0, dry_run.stderr[-2000:]
    if "Nothing to be done" in dry_run.stdout + dry_run.stderr:
        return set()
    lines = dry_run.stdout.split("Job stats:")[1].split("\n\n")[0].splitlines()[3:]
    return {line.split()[0] for line in lines} - {"all", "total"}
