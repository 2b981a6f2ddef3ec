"""Timing keeps every run, leaves warm-ups out and takes turns."""

from functools import partial

from evaluation.lib.machine import time_rounds


def test_work_takes_turns_and_every_counted_run_is_kept_and_no_warm_up():
    # A clock that work itself moves on; warm-ups take 6 to 9 s.
    durations = {"slow": iter([9.0, 4.0, 8.0, 5.0]), "fast": iter([7.0, 0.25, 6.0, 0.5])}
    moments = [100.0]

    def work(name):
        moments.append(moments[-1] + next(durations[name]))

    runs = time_rounds(
        {name: partial(work, name) for name in durations}, 2, clock=lambda: moments[-1]
    )
    # Binary fractions: the differences are exact.
    assert runs == [("slow", 0, 4.0), ("fast", 0, 0.25), ("slow", 1, 5.0), ("fast", 1, 0.5)]
    order = []
    time_rounds({name: lambda n=name: order.append(n) for name in "ab"}, 2, n_warm_up=2)
    assert "".join(order) == "aaabbbaaabbb"
