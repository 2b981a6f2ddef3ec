"""Seconds of processor time per training step and per render of the cGAN by width, and per render of PHY."""

import dataclasses
import time
from functools import partial

import pandas as pd
import torch
from job import job
from render_phy import render_scene

from lib.timing import device_name, time_rounds
from snowsim.cgan import Settings, Training, render, train_steps
from snowsim.io.files import read_dataset, write_table
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream

N_SCENES = 8  # of the train set, timed in turn


def measure(paths_to_train, path_to_statistics, path_to_table, seed, settings, widths, n_rounds, phy):
    torch.set_num_threads(1)
    with SceneSet(paths_to_train) as train:
        scenes = [train[number] for number in range(min(N_SCENES, len(train)))]
    flight = read_dataset(path_to_statistics)

    def render_all(render_one):
        for scene in scenes:
            render_one(scene)

    def take_steps(steps):
        for _ in scenes:
            next(steps)

    def by_cgan(generator, scene):
        render(generator, scene.mask(), statistics="scene", precision=settings["precision"],
               rng=random_stream(seed, "study_cgan_speed", scene.name))  # fmt: skip

    works = {}
    for width in widths:
        endless = dataclasses.replace(Settings(**settings), width=width, n_steps=10**9)
        training = Training(endless, seed=seed)
        works["cgan", width, "step"] = partial(take_steps, train_steps(training, scenes))
        works["cgan", width, "render"] = partial(render_all, partial(by_cgan, training.generator))
    stream = random_stream(seed, "study_cgan_speed", "phy")
    works["phy", 0, "render"] = partial(render_all, lambda scene: render_scene(scene, flight, phy, stream))
    rows = [
        {"method": method, "width": width, "work": work, "repeat": repeat, "seconds": seconds / len(scenes)}
        for (method, width, work), repeat, seconds in time_rounds(works, n_rounds, clock=time.process_time)
    ]
    write_table(path_to_table, pd.DataFrame(rows).assign(device=device_name()))


if __name__ == "__main__":
    with job(snakemake):
        measure(snakemake.input.train, snakemake.input.statistics, snakemake.output.table, **snakemake.params)
