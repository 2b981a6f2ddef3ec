"""Seconds of one core for a training set of 1500 scenes, and for an echogram of each radar: ``make benchmarks``."""

import time

import numpy as np

import snowsim
from snowsim.physical.radar import PRESETS

N_SCENES, N_LINES = 1500, 1000


def seconds(work):
    start = time.process_time()
    work()
    return time.process_time() - start


first = seconds(lambda: snowsim.scenes(1, rng=0)[0])
print(f"first scene, with what is compiled once: {first:.1f} s")
for radiometry in ("constant", "measured"):
    scenes = snowsim.scenes(N_SCENES, rng=1, radiometry=radiometry)
    print(f"{N_SCENES} scenes, radiometry {radiometry}: {seconds(lambda: [0 for _ in scenes]):.1f} s")  # noqa: B023
climate = snowsim.Climate(accumulation_m=0.3)
for name in PRESETS:
    took = seconds(lambda: snowsim.simulate(climate, name, n_range_lines=N_LINES, rng=np.random.default_rng(1)))  # noqa: B023
    print(f"{N_LINES} range lines of {name}: {took:.2f} s")
