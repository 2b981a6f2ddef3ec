"""Runs of the workflow in folders of their own."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SNAKEMAKE = Path(sys.executable).with_name("snakemake")


def run_snakemake(folder, *arguments, configs=("config.yaml", "tiny.yaml"), cores=2, timeout=540):
    """Run the workflow with results in `folder`; gives the finished process with its output as text."""
    command = [
        SNAKEMAKE,
        *("--snakefile", ROOT / "Snakefile"),
        *("--directory", folder),
        *("--workflow-profile", ROOT / "profiles/default"),
        *("--cores", cores),
        *("--configfile", *[ROOT / "config" / config for config in configs]),
        *arguments,
    ]
    return subprocess.run(
        [str(word) for word in command], capture_output=True, text=True, timeout=timeout, check=False, cwd=ROOT
    )
