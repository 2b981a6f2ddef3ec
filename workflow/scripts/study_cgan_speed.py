"""Seconds of processor time per training step and per render of the cGAN by width, and per render of PHY."""

from functools import partial

from job import run

from lib.diagnostics.cgan_studies import time_widths
from snowsim.io.files import read_dataset, write_table
from snowsim.io.scenes import SceneSet
from snowsim.phy import render_scene
from snowsim.seeding import random_stream

N_SCENES = 8  # of the train set, timed in turn


def measure(train, statistics, table, *, seed, settings, widths, n_rounds, phy):
    with SceneSet(train) as held:
        scenes = [held[number] for number in range(min(N_SCENES, len(held)))]
    flight = read_dataset(statistics)
    stream = partial(random_stream, seed, "study_cgan_speed")
    by_phy = partial(render_scene, statistics=flight, **phy, rng=stream("phy"))
    write_table(table, time_widths(scenes, widths, settings, by_phy, n_rounds, seed=seed, stream=stream))


run(measure)
