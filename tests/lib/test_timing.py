"""Timing keeps every run, leaves warm-ups out and takes turns."""

import pytest

from lib.machine import time_rounds


class Clock:
    """A clock that work itself moves on."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now

    def work(self, *durations):
        durations = iter(durations)

        def run():
            self.now += next(durations)

        return run


def test_every_counted_run_is_kept_and_warm_ups_are_not():
    clock = Clock()
    works = {"slow": clock.work(9.0, 4.0, 8.0, 5.0), "fast": clock.work(7.0, 0.25, 6.0, 0.5)}
    runs = time_rounds(works, 2, clock=clock)
    # Binary fractions: the differences are exact. From 6 to 9 s: warm-ups.
    assert runs == [("slow", 0, 4.0), ("fast", 0, 0.25), ("slow", 1, 5.0), ("fast", 1, 0.5)]


def test_work_takes_turns_warm_ups_included():
    order = []
    time_rounds({name: lambda n=name: order.append(n) for name in "ab"}, 2, n_warm_up=2)
    assert "".join(order) == "aaabbbaaabbb"


@pytest.mark.parametrize(("n_rounds", "n_warm_up"), [(0, 1), (3, -1)])
def test_no_rounds_are_refused(n_rounds, n_warm_up):
    with pytest.raises(ValueError, match=f"got {n_rounds} and {n_warm_up}"):
        time_rounds({}, n_rounds, n_warm_up=n_warm_up)
