"""Runs of the workflow in folders of their own, from a copy of its source that tests may edit."""

import atexit
import fcntl
import functools
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest
import yaml
from processes import ROOT
from snakemake.api import SnakemakeApi
from snakemake.exceptions import WorkflowError
from snakemake.settings.types import (
    ConfigSettings,
    DAGSettings,
    OutputSettings,
    Quietness,
    ResourceSettings,
)

from lib.configuration import filled, read_schema

# The default as it is written, and as rules read it; and the schema of the former.
WRITTEN = yaml.safe_load((ROOT / "config/config.yaml").read_text())
CONFIG = filled(WRITTEN)
SCHEMA = read_schema()
SNAKEMAKE = Path(sys.executable).with_name("snakemake")
TINY = ("config.yaml", "tiny.yaml")
PARTS = ("Snakefile", "workflow", "snowsim", "config", "profiles", "envs")


def copy_source(folder):
    """Copy what a run reads to a folder; times of files are kept."""
    folder.mkdir(exist_ok=True)
    for name in PARTS:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy2
        copy(ROOT / name, folder / name)
    return folder


@functools.cache
def source_tree():
    """Copy of what a run reads, the same for all tests of a process; edits must be undone."""
    folder = Path(tempfile.mkdtemp(prefix="snowsim_source_"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return copy_source(folder)


def made_once(path, make):
    """`path` as `make` made it for the first process to ask; a half-made one is made anew."""
    with path.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not path.with_suffix(".made").exists():
            shutil.rmtree(path, ignore_errors=True)
            make(path)
            path.with_suffix(".made").touch()
    return path


def command(folder, *arguments, configs=TINY, cores=2, profile="default", source=None):
    """Words of a call of Snakemake with results in `folder`."""
    source = source or source_tree()
    words = [SNAKEMAKE, "--snakefile", source / "Snakefile", "--directory", folder]
    words += ["--workflow-profile", source / "profiles" / profile, "--cores", cores]
    words += ["--configfile", *[source / "config" / config for config in configs]]
    words += arguments
    return [str(word) for word in words]


def environment(source=None, **changes):
    """Environment of a run: the package is the copy's, compiled once for all jobs."""
    own = {"PYTHONPATH": str(source or source_tree()), "PYTHONDONTWRITEBYTECODE": ""}
    return os.environ | own | changes


def call(*words, cwd=None, timeout=300, env=None):
    """The finished process of some words with its output, by default in the copied source."""
    return subprocess.run(
        [str(word) for word in words],
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
        cwd=cwd or source_tree(),
        env=env or environment(),
    )


def run_snakemake(folder, *arguments, fails=False, timeout=540, env=None, source=None, **options):
    """The finished run of the workflow in `folder`, well unless it `fails`; see `command`."""
    words = command(folder, *arguments, source=source, **options)
    done = call(*words, timeout=timeout, cwd=source, env=env or environment(source))
    assert (done.returncode != 0) == fails, text_of(done)[-4000:]
    return done


def parsed(folder, configs=TINY, targets=(), snakefile="Snakefile", **config):
    """The workflow as Snakemake reads it for a run in `folder`; targets are planned."""
    files = [ROOT / "config" / name for name in configs]
    with SnakemakeApi(OutputSettings(dryrun=True, quiet={Quietness.ALL})) as api:
        workflow = api.workflow(
            ResourceSettings(cores=1),
            ConfigSettings(config=config, configfiles=files),
            snakefile=ROOT / snakefile,
            workdir=folder,
        )
        # As in the profile.
        dag = workflow.dag(DAGSettings(targets=set(targets), max_checksum_file_size=4 * 10**9))
        if targets:
            dag.execute_workflow(executor="dryrun")
        return dag.workflow_api._workflow


def rules_planned(folder, configs=TINY, targets=("all",), *, source=None):
    """Names of the rules that would run in `folder`, and of those that an edit triggers."""
    snakefile = (source or source_tree()) / "Snakefile"
    dag = parsed(folder, configs, targets, snakefile).dag
    jobs = list(dag.needrun_jobs(exclude_finished=False))
    triggered = {job.rule.name for job in jobs if dag.reason(job).is_provenance_triggered()}
    return {job.rule.name for job in jobs} - {"all"}, triggered


def refused(folder, *configs, **config):
    """The one line with which Snakemake refuses to read the workflow; nothing is written."""
    with pytest.raises(WorkflowError) as error:
        parsed(folder, *configs, **config)
    assert not (folder / "results").exists()
    assert "\n" not in str(error.value)
    return str(error.value)


def settings(folder, text):
    """Configuration files of the tiny run with what differs, YAML."""
    folder.mkdir(exist_ok=True)
    path = folder / "settings.yaml"
    path.write_text(f"{text}\n")
    return *TINY, path


def text_of(done):
    """All that a finished process printed."""
    return done.stdout + done.stderr


def lines_with(done, start):
    """Lines that a finished process printed and that start so."""
    return [line for line in text_of(done).splitlines() if line.startswith(start)]


def wait_until(holds, seconds):
    """Whether a condition comes to hold within some seconds."""
    for _ in range(10 * seconds):
        if holds():
            return True
        time.sleep(0.1)
    return False


def rules_to_run(dry_run):
    """Names of the rules in the job table of a dry run, that of the default target left out."""
    after = dry_run.stdout.split("Job stats:")[1]
    table = after.split("\n\n")[0]
    names = {line.split()[0] for line in table.splitlines()[3:]}
    return names - {"all", "total"}
