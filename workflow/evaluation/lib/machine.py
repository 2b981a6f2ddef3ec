"""Description of the machine and software that a run uses, and timing of work on it."""

import os
import platform
import time
from importlib import metadata
from pathlib import Path

import psutil

PACKAGES = (
    "snowsim",
    "numpy",
    "scipy",
    "numba",
    "xarray",
    "scikit-image",
    "matplotlib",
    "pandas",
    "torch",
    "snakemake",
)


def describe_machine():
    """Processor, cores in reach, memory, system and Python as texts by name."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return {
        "processor": processor_model() or platform.processor() or platform.machine(),
        "cores in reach": str(cores),
        "memory": f"{psutil.virtual_memory().total / 2**30:.0f} GiB",
        "system": f"{platform.system()} {platform.release()}, {platform.machine()}",
        "Python": platform.python_version(),
    }


def processor_model():
    """Model of the processor as the kernel of Linux names it; empty where it does not."""
    path = Path("/proc/cpuinfo")
    lines = path.read_text().splitlines() if path.is_file() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else ""


def describe_versions():
    """Versions of this package and of the packages it uses, by name, if they are installed."""
    versions = {}
    for name in PACKAGES:
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return versions


def device_name():
    """Kind of processor that a time was measured on."""
    return f"cpu {platform.machine()}, 1 thread"


def time_rounds(works, n_rounds, *, n_warm_up=1, clock=time.perf_counter):
    """Time works, callables by name; runs ``(name, repeat, seconds)`` in the order they were made.

    Every work runs once in each round, so that a busy machine slows all of them alike. Right before
    it runs `n_warm_up` times, to compile and to fill the cache. ValueError without a round.
    """
    if n_rounds < 1 or n_warm_up < 0:
        got = f"got {n_rounds} and {n_warm_up}"
        msg = f"expected n_rounds of at least 1 and n_warm_up of at least 0, {got}"
        raise ValueError(msg)
    runs = []
    for repeat in range(n_rounds):
        for name, work in works.items():
            for _ in range(n_warm_up):
                work()
            start = clock()
            work()
            runs.append((name, repeat, clock() - start))
    return runs
