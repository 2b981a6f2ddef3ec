"""What a job shows while it runs, and the memory left to it: no result depends on this file."""

import sys

from tqdm import tqdm

from lib.machine import kernel_field


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
