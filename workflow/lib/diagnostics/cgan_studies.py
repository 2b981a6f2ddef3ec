"""Studies of the conditional GAN: its spread over seeds, its cost by width, and where its training collapses."""

import dataclasses
import time
from functools import partial

import pandas as pd

from lib.cgan_training import examine
from lib.machine import device_name, time_rounds
from snowsim.cgan import Settings, Training, faults, render, train_steps

METRICS = ["ssim", "psnr", "rmse"]


def seeds_table(default, others, seeds):
    """Means of Table II by seed of the cGAN, their spread, and PHY's, from tables of similarity by image."""
    runs = [default[default["method"] == "cgan"], *others]
    means = pd.DataFrame([run[METRICS].mean() for run in runs], index=[f"cGAN, seed {seed}" for seed in seeds])
    spread = {
        "cGAN, mean": means.mean(),
        "cGAN, standard deviation": means.std(ddof=1),
        "PHY": default.loc[default["method"] == "phy", METRICS].mean(),
    }
    return pd.concat([means, pd.DataFrame(spread).T]).rename_axis("run").reset_index()


def time_widths(scenes, widths, settings, render_phy, n_rounds, *, seed, stream):
    """Seconds of processor time per training step and per render by width, and per render of PHY: a row a run."""

    def take_steps(steps):
        for _ in scenes:
            next(steps)

    def by_cgan(generator):
        for scene in scenes:
            render(generator, scene.mask(), statistics="scene", precision=precision, rng=stream(scene.name))

    def by_phy():
        for scene in scenes:
            render_phy(scene)

    works, precision = {}, settings["precision"]
    for width in widths:
        endless = dataclasses.replace(Settings(**settings), width=width, n_steps=10**9)
        training = Training(endless, seed=seed)
        works["cgan", width, "step"] = partial(take_steps, train_steps(training, scenes))
        works["cgan", width, "render"] = partial(by_cgan, training.generator)
    works["phy", 0, "render"] = by_phy
    rows = [
        {"method": method, "width": width, "work": work, "repeat": repeat, "seconds": seconds / len(scenes)}
        for (method, width, work), repeat, seconds in time_rounds(works, n_rounds, clock=time.process_time)
    ]
    return pd.DataFrame(rows).assign(device=device_name())


def steps_in(seconds, speed, width):
    """Steps that a training of this width takes in so much processor time, by a table of `time_widths`."""
    of_width = speed[(speed["method"] == "cgan") & (speed["width"] == width) & (speed["work"] == "step")]
    return max(1, round(seconds / of_width["seconds"].median()))


def widths_table(speed, bounds, validations):
    """Seconds per step and render, and similarity on held-out train scenes, by width of the cGAN, beside PHY.

    `validations` maps (mode, width) to those of a training, of which the fittest counts; PHY's are those of `bounds`.
    """
    seconds = speed.groupby(["method", "width", "work"])["seconds"].median()
    rows = []
    for (mode, width), validation in validations.items():
        best = validation.loc[validation["fitness"].idxmax()]
        row = {"method": "cgan", "mode": mode, "width": width, "n_steps": int(validation["step"].iloc[-1])}
        row |= {f"seconds_per_{work}": seconds["cgan", width, work] for work in ("step", "render")}
        rows.append(row | best[["psnr", "ssim", "rmse"]].to_dict() | {"n_faults": int(best["n_faults"])})
    same_scenes = (bounds["scenes"] != "test") & (bounds["layers"] == "as picked") & (bounds["method"] == "phy")
    phy = {"method": "phy", "mode": "none", "width": 0, "n_steps": 0, "n_faults": 0}
    phy |= {"seconds_per_render": seconds["phy", 0, "render"]} | bounds.loc[same_scenes, METRICS].iloc[0].to_dict()
    return pd.DataFrame([*rows, phy])


def train_and_examine(settings, seed, train_scenes, held_scenes, statistics):
    """Similarity, numbers of health and outcome of one training; a loss that is not finite ends it."""
    training = Training(settings, seed=seed)
    try:
        losses = [step_losses for _, step_losses in train_steps(training, train_scenes)]
        scores, numbers, _ = examine(training, losses, held_scenes, statistics)
    except FloatingPointError as error:
        return {"outcome": f"values that are not finite: {error}"}
    return {**scores, **numbers, "outcome": "; ".join(faults(numbers, dropout=settings.dropout)) or "healthy"}
