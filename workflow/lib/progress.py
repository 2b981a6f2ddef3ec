"""What a job shows while it runs, and the memory left to it: no result depends on this file."""

import sys
from pathlib import Path

from tqdm import tqdm


def kernel_field(path, name):
    """A field of a "name : value" file of the kernel; empty where there is none."""
    path = Path(path)
    lines = path.read_text().splitlines() if path.is_file() else []
    for line in lines:
        if line.startswith(name):
            return line.partition(":")[2].strip()
    return ""


def available_memory_mb():
    """Memory this machine can give without swapping [MB]; None where the system does not say."""
    available = kernel_field("/proc/meminfo", "MemAvailable")
    return float(available.split()[0]) / 1024 if available else None


def progress(iterable, description, total=None, initial=0):
    """Iterate with a progress bar on stderr, redrawn every few seconds where it is no terminal."""
    interval = 0.5 if sys.stderr.isatty() else 15
    return tqdm(
        iterable,
        description,
        total=total,
        initial=initial,
        mininterval=interval,
        miniters=1,
        dynamic_ncols=True,
    )
