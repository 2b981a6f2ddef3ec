"""Progress bars, which appear only on a terminal."""

from tqdm import tqdm


def with_progress(steps, total=None, *, unit):
    """Iterator over steps, with a progress bar that counts them and disappears at the end."""
    return tqdm(steps, unit=unit, total=total, leave=False, disable=None)


def bar_of_files(total):
    """Progress bar that counts files, with the time that is left, and disappears at the end."""
    return tqdm(unit="file", total=total, leave=False, disable=None)
