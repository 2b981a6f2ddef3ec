"""Seconds of one core for 1500 scenes, and for an echogram of each radar: ``make benchmarks``."""

import sys
import time

import numpy as np

import snowsim
from snowsim.physical import PRESETS

N_SCENES, N_LINES = 1500, 1000
say = sys.stdout.write


def seconds(work, *given, **options):
    start = time.process_time()
    work(*given, **options)
    return time.process_time() - start


say(f"first scene, with what is compiled once: {seconds(list, snowsim.scenes(1, rng=0)):.1f} s\n")
for radiometry in ("constant", "measured"):
    scenes = snowsim.scenes(N_SCENES, rng=1, radiometry=radiometry)
    taken = seconds(list, (image.size for image, _ in scenes))
    say(f"{N_SCENES} scenes, radiometry {radiometry}: {taken:.1f} s\n")
climate, rng = snowsim.Climate(accumulation_m=0.3), np.random.default_rng(1)
for name in PRESETS:
    took = seconds(snowsim.simulate, climate, name, n_range_lines=N_LINES, rng=rng)
    say(f"{N_LINES} range lines of {name}: {took:.2f} s\n")
