"""Captions as written for figures: their title, and the figures of the paper they name."""

import re

FIGURES = re.compile(r"paper, Figs? (\d+)(?:(?:-| to )(\d+)|(?:, (\d+))? and (\d+))?")
LONGEST_TITLE = 110


def paper_figures(caption):
    """Numbers of the paper's figures that a caption names ("paper, Fig. 8", "Figs 6 and 7", "Figs 10-12"), sorted."""
    numbers = set()
    for first, last, *others in FIGURES.findall(caption.replace("Fig.", "Fig")):
        numbers |= set(range(int(first), int(last or first) + 1)) | {int(number) for number in others if number}
    return sorted(numbers)


def title_of(caption):
    """The first clause of a caption, without what stands in brackets, at most 110 characters."""
    plain = re.sub(r"\s*\([^)]*\)", "", " ".join(caption.split()))
    title = re.split(r"[:.;](?:\s|$)", plain, maxsplit=1)[0]
    if len(title) > LONGEST_TITLE:
        title = title[:LONGEST_TITLE].rsplit(" ", 1)[0] + " ..."
    return title


def counterparts(figures, paper_numbers):
    """Which figures of the report answer each of the paper's.

    Parameters
    ----------
    figures : list of dict
        With `name` and `caption`.
    paper_numbers : iterable of int

    Returns
    -------
    dict
        Number -> list of the figures whose captions name it.
    """
    return {number: [f for f in figures if number in paper_figures(f["caption"])] for number in paper_numbers}
