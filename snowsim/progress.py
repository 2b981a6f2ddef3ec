"""Progress bars on a terminal; there is none where output is no terminal."""

from tqdm import tqdm


def shown(steps, total=None, *, unit):
    """Iterate over steps beside a bar that counts them in a unit and disappears at the end."""
    return tqdm(steps, unit=unit, total=total, leave=False, disable=None)
