"""Progress bars of a job; no result depends on this file."""

import sys

from tqdm import tqdm


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
