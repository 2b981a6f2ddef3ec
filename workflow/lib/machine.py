"""The machine and the software a run uses, as far as they can be told, and the progress it shows."""

import os
import platform
import sys
from importlib import metadata
from pathlib import Path

from tqdm import tqdm

PACKAGES = ("numpy", "scipy", "numba", "xarray", "scikit-image", "matplotlib", "pandas", "torch", "snakemake")


def describe_machine():
    """Names and texts: processor, cores in reach, memory, system, Python."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return {
        "processor": _field("/proc/cpuinfo", "model name") or platform.processor() or platform.machine(),
        "cores in reach": str(cores),
        "memory": _memory(),
        "system": f"{platform.system()} {platform.release()}, {platform.machine()}",
        "Python": platform.python_version(),
    }


def describe_versions(packages=PACKAGES):
    """Version of this package and of those it leans on, by name; without those that are not installed."""
    versions = {}
    for name in ("snowsim", *packages):
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return versions


def available_memory_mb():
    """Memory this machine can still give without swapping [MB]; None where the system does not say."""
    available = _field("/proc/meminfo", "MemAvailable")
    return float(available.split()[0]) / 1024 if available else None


def progress(iterable, description, total=None, initial=0):
    """Iterate with a progress bar on stderr, redrawn at most every few seconds where it is no terminal."""
    interval = 0.5 if sys.stderr.isatty() else 15
    return tqdm(
        iterable, description, total=total, initial=initial, mininterval=interval, miniters=1, dynamic_ncols=True
    )


def _field(path, name):
    """A field of a "name : value" file of the kernel; empty where there is none."""
    path = Path(path)
    lines = path.read_text().splitlines() if path.is_file() else []
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith(name)), "")


def _memory():
    total = _field("/proc/meminfo", "MemTotal")
    return f"{int(total.split()[0]) / 2**20:.0f} GiB" if total else "unknown"
