"""Progress bars, shown only if the output is a terminal."""

from tqdm import tqdm


def with_progress(steps, total=None, *, unit):
    """Steps to iterate over, with a progress bar that counts them and disappears at the end."""
    return tqdm(steps, unit=unit, total=total, leave=False, disable=None)
