"""Tracks segments side by side, each in one of several processes."""

import copy
import multiprocessing
import os
import signal
import sys
import threading
import time
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass

from snowsim import progress
from snowsim.tracking.segments import Output, track_segment
from snowsim.tracking.trackers import Tracker

INTERVAL_S = 0.5  # between looks at what was counted, and at whether the parent runs


@dataclass(frozen=True, eq=False)
class _Work:
    """What a process tracks with; it counts files and range lines, unless it is to stop."""

    tracker: Tracker
    output: Output
    counts: object
    stop: object

    def count(self, n_lines):
        """Count a file of so many range lines."""
        with self.counts.get_lock():
            self.counts[0] += 1
            self.counts[1] += n_lines


_work = None  # of this process


def track_side_by_side(tracker, segments, output, processes, say, advance):
    """`track_segment` of all segments in several processes; the number of files that failed.

    Lines about a segment are said when it is done. `advance` is called with the numbers of range
    lines and files since the last time. ChildProcessError if a process was killed.
    """
    counts = multiprocessing.Array("q", 2)
    stop = multiprocessing.Event()
    others = set(multiprocessing.active_children())
    work = (tracker, output, counts, stop, os.getpid())
    pool = ProcessPoolExecutor(processes, initializer=_begin, initargs=work)
    n_failed = n_files = n_lines = 0
    waiting = segments
    try:
        waiting = {pool.submit(_track, files) for files in segments}
        while waiting:
            done, waiting = wait(waiting, INTERVAL_S, FIRST_COMPLETED)
            now_files, now_lines = counts[:]
            advance(now_lines - n_lines, now_files - n_files)
            n_files, n_lines = now_files, now_lines
            for segment in done:
                lines, n_failed_here = segment.result()
                n_failed += n_failed_here
                for line in lines:
                    say(line)
    except BrokenProcessPool as error:
        msg = "a process was killed: is there memory for so many? --resume (resume=True) goes on"
        raise ChildProcessError(msg) from error
    finally:
        stop.set()
        for child in set(multiprocessing.active_children()) - others if waiting else ():
            child.terminate()
        pool.shutdown(cancel_futures=True)
    return n_failed


def _begin(tracker, output, counts, stop, parent):
    """Prepare this process: the parent alone answers Ctrl-C, and ends it by SIGTERM."""
    global _work
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    progress.hide()
    # A copy has a session of its own: one of onnxruntime may not survive a fork.
    _work = _Work(copy.copy(tracker), output, counts, stop)


def _end_with(parent):
    """End this process when its parent has ended, which may have been killed."""
    while os.getppid() == parent:
        time.sleep(INTERVAL_S)
    os._exit(1)


def _track(files):
    """Lines about a segment, and the number of its files that failed."""
    if _work.stop.is_set():
        return [], 0
    lines = []
    n_failed = track_segment(_work.tracker, files, _work.output, lines.append, _work.count)
    return lines, n_failed
