"""Tracks files: one segment after another, each written when its last frame was seen."""

import os
import time
from pathlib import Path
from tempfile import TemporaryFile

from snowsim.io.files import refusal
from snowsim.io.models import shipped_trackers
from snowsim.limits import check_count
from snowsim.progress import bar_of_files
from snowsim.tracking.plan import plan
from snowsim.tracking.segments import Output, track_segment
from snowsim.tracking.trackers import Tracker


def track_files(
    paths,
    folder,
    *,
    model="universal",
    png=False,
    bin_s=None,
    force=False,
    resume=False,
    processes=1,
    say=print,
    progress=None,
):
    """Track echograms and write their layers to a folder.

    Frames of a segment that follow one another are tracked as one, and the segment is written when
    its last frame was seen. A frame that cannot be tracked is named and left out; layers do not go
    on over it. Each segment gives `SEGMENT_layers.nc`, with `frame` along slow_time, and the layer
    files of `snowsim.io.layers`. An image gives `NAME_layers.nc` alone, with rows of the image
    beside travel times.

    Parameters
    ----------
    paths : sequence of path_like
    folder : path_like
        It is made if it is missing.
    model : str
        Name of `list_pretrained`, or path of an ONNX file.
    png : bool
        Draw picks on each echogram, as `NAME_picks.png`, or, of more than 2000 range lines, as
        `NAME_picks_01.png` and so on.
    bin_s : float, optional
        Range bin of images [s].
    force : bool
        Replace files that exist; a file beside its own input is never replaced.
    resume : bool
        Leave segments that were written whole from the same files by the same tracker, and replace
        what is left of others that were begun. What was made of other files or by another tracker
        is refused. Of a segment of more than 20 frames, what was detected before an interrupt is in
        the folder `.unfinished`, and is used.
    processes : int
        Number of processes that work at once, each on a segment; layers do not depend on it.
    say : callable
        It is called with one line for each note, error and file written.
    progress : callable, optional
        It is called with the number of files and returns a bar like tqdm's, which counts them and
        shows how many range lines are tracked a second.

    Returns
    -------
    int
        Number of files that failed.

    Raises
    ------
    ValueError
        In one line, before anything is tracked: the folder cannot be written to, two files have the
        same name, an image has that of a segment, `bin_s` is given without an image, or the tracker
        is damaged.
    ChildProcessError
        If one of several processes is killed, as where memory ends.
    """
    check_count("processes", processes)
    tracker = Tracker.load(shipped_trackers().get(model, model))
    paths = [Path(path) for path in paths]
    output = Output(_writable_folder(folder), png, bin_s, force, resume)
    segments, failed = plan(paths)
    if bin_s is not None and segments and all(files[0].segment for files in segments):
        msg = (
            "bin_s: expected an image among the files, whose range bin it is, found echograms alone"
        )
        raise ValueError(msg)
    for message in failed:
        say(f"error: {message}")
    n_failed = len(failed)
    bar = (progress or bar_of_files)(len(paths) - n_failed)
    begin = time.monotonic()
    n_lines = 0

    def advance(n_further_lines, n_files=1):
        nonlocal n_lines
        n_lines += n_further_lines
        bar.set_postfix_str(f"{n_lines / (time.monotonic() - begin):,.0f} range lines/s", False)
        bar.update(n_files)

    try:
        if processes > 1:
            from snowsim.tracking.processes import track_side_by_side

            n_failed += track_side_by_side(tracker, segments, output, processes, say, advance)
        else:
            for segment in segments:
                n_failed += track_segment(tracker, segment, output, say, advance)
    finally:
        bar.close()
    return n_failed


def _writable_folder(folder):
    """Path of the folder, made if it is missing; ValueError unless it can be written to."""
    try:
        os.makedirs(
            folder, exist_ok=True
        )  # not of a Path: an empty name would become the current folder
        with TemporaryFile(dir=folder):
            return Path(folder)
    except OSError as error:
        wanted = "a folder that can be written to"
        raise refusal(folder, "output", wanted, error.strerror) from error
