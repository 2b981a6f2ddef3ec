"""The plan of a run: which files are frames of which segment, in which order."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from snowsim.echogram import named_frame
from snowsim.io import read_echogram
from snowsim.io.echograms import frame_in
from snowsim.io.files import image_format_of, noted, refusal


@dataclass(frozen=True)
class File:
    """A file to track. `begin` is its first time, if its name does not say which frame it is.

    Segment and number of an image are None.
    """

    path: Path
    segment: str | None
    number: int | None
    begin: np.datetime64 | None = None


def plan(paths):
    """Segments, a list of lists of `File` in order of their numbers; and messages of bad files.

    Each image is a segment of its own. A file is opened here if its name does not hold segment and
    frame. Frames without a number are numbered after the others of their segment, by time.
    ValueError if two files have the same name, or an image has that of a segment.
    """
    _refuse_equal_names(paths)
    segments = {}
    failed = []
    seen = {}
    for path in paths:
        try:
            file = _identified(path)
            frame = (file.segment, file.number)
            if file.number is not None and frame in seen:
                raise refusal(path, "frame", "one file of each", f"that of {seen[frame]}")
        except (ValueError, OSError) as error:
            failed.append(str(error))
            continue
        seen[frame] = path
        segments.setdefault(file.segment or ("image", path), []).append(file)
    segments = [_in_order(files) for files in segments.values()]
    _refuse_name_of_segment(segments)
    return segments, failed


def _identified(path):
    """`File` of a path; ValueError if it is a pipe, or if it must be opened and is no echogram."""
    if path.is_fifo():
        raise refusal(path, "file", "one that can be read more than once", "a pipe")
    if image_format_of(path) is not None:
        return File(path, None, None)
    segment, number = named_frame(path)
    if segment is not None:
        return File(path, segment, number)
    with noted(path):  # notes are given when it is tracked
        echogram = read_echogram(path)
    segment, number = frame_in(echogram, path)
    return File(path, segment, number, echogram["slow_time"].values[0])


def _in_order(files):
    """Files of a segment in order of their numbers; those without one follow, by time."""
    if files[0].segment is None:
        return files
    known = [file for file in files if file.number is not None]
    others = sorted((file for file in files if file.number is None), key=lambda file: file.begin)
    first = 1 + max((file.number for file in known), default=0)
    added = [replace(file, number=number) for number, file in enumerate(others, first)]
    return sorted(known, key=lambda file: file.number) + added


def _refuse_equal_names(paths):
    """Refuse two files whose outputs would have the same name."""
    first = {}
    for path in paths:
        if path.stem in first:
            wanted = "files of different names, for their layers are named by them"
            raise refusal(path, "name", wanted, f"{first[path.stem]} too")
        first[path.stem] = path


def _refuse_name_of_segment(segments):
    """Refuse an image whose layers would have the name of a segment's."""
    names = {files[0].segment for files in segments}
    for file, *_ in segments:
        if file.segment is None and file.path.stem in names:
            raise refusal(file.path, "name", "another than that of a segment", file.path.stem)
