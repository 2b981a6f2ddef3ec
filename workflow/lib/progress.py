"""Progress bars and free memory of a job; no result depends on this file."""

import sys
from pathlib import Path

from tqdm import tqdm


def kernel_field(path, name):
    """Value of a name in a file of the kernel with lines "name : value"; empty if it has none."""
    path = Path(path)
    lines = path.read_text().splitlines() if path.is_file() else []
    for line in lines:
        if line.startswith(name):
            return line.partition(":")[2].strip()
    return ""


def available_memory_mb():
    """Memory that is available without swapping [MB]; None if the system does not say."""
    available = kernel_field("/proc/meminfo", "MemAvailable")
    return float(available.split()[0]) / 1024 if available else None


def progress(iterable, description, total=None, initial=0):
    """Iterate with a progress bar on stderr, which is redrawn seldom where that is no terminal."""
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
