"""Progress bars, which appear only on a terminal."""

from tqdm import tqdm

# None: shown on a terminal.
_is_hidden = None


def with_progress(steps, total=None, *, unit):
    """Iterator over steps, with a progress bar that counts them and disappears at the end."""
    return tqdm(steps, unit=unit, total=total, leave=False, disable=_is_hidden)


def bar_of_files(total):
    """Progress bar that counts files, with the time that is left, and disappears at the end."""
    return tqdm(unit="file", total=total, leave=False, disable=_is_hidden)


def hide():
    """Show no bars in this process from now on, as it works beside others."""
    global _is_hidden
    _is_hidden = True
