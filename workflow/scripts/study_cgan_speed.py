"""Seconds of processor time per training step and per render of the cGAN by width, and per render of PHY."""

import torch
from job import run
from render_phy import render_scene

from lib.diagnostics.cgan_studies import time_widths
from snowsim.io.files import read_dataset, write_table
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream

N_SCENES = 8  # of the train set, timed in turn


def measure(train, statistics, table, *, seed, settings, widths, n_rounds, phy):
    torch.set_num_threads(1)
    with SceneSet(train) as held:
        scenes = [held[number] for number in range(min(N_SCENES, len(held)))]
    flight = read_dataset(statistics)

    def stream(name):
        return random_stream(seed, "study_cgan_speed", name)

    rng = stream("phy")

    def by_phy(scene):
        render_scene(scene, flight, phy, rng)

    write_table(table, time_widths(scenes, widths, settings, by_phy, n_rounds, seed=seed, stream=stream))


run(measure)
