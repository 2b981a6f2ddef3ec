"""Bars of progress on a terminal; none where nobody looks."""

from tqdm import tqdm


def shown(steps, total=None, *, unit):
    """The steps, one by one, with a bar that counts them in a unit and goes when they end."""
    return tqdm(steps, unit=unit, total=total, leave=False, disable=None)
