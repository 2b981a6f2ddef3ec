"""Seconds of every repeat of work that is compared, measured in turn."""

import platform
import time


def time_rounds(works, n_rounds, *, n_warm_up=1, clock=time.perf_counter):
    """Time several pieces of work in rounds: each runs once a round, so that a busy machine slows all of them alike.

    Parameters
    ----------
    works : mapping of str or tuple to callable
        Work by its name; called without arguments, what it returns is dropped.
    n_rounds : int
        Rounds that count, at least 1.
    n_warm_up : int
        Runs right before each run that counts: they compile, and bring back to the cache what other work drove out.
    clock : callable
        Gives seconds; monotonic.

    Returns
    -------
    list of tuple
        ``(name, repeat, seconds)`` of every run that counts, in the order they ran.

    Raises
    ------
    ValueError
        If there is no round or a negative number of warm-ups.
    """
    if not (n_rounds >= 1 and n_warm_up >= 0):
        msg = f"expected n_rounds of at least 1 and n_warm_up of at least 0, got {n_rounds} and {n_warm_up}"
        raise ValueError(msg)
    runs = []
    for repeat in range(n_rounds):
        for name, work in works.items():
            for _ in range(n_warm_up):
                work()
            start = clock()
            work()
            runs.append((name, repeat, clock() - start))
    return runs


def device_name():
    """Where the clock ran: kind of processor, one thread."""
    return f"cpu {platform.machine()}, 1 thread"
