"""Train the cGAN at one width, for as many steps as the other widths or for as much processor time."""

from job import run
from train_cgan import train as train_cgan

from lib.diagnostics.cgan_studies import steps_in
from snowsim.io.files import read_table

N_VALIDATIONS = 4


def train_width(
    train, speed, generator, losses, scores, samples, *, mode, width, n_steps, seconds, training, checkpoint, events
):  # fmt: skip
    if mode == "equal_time":
        n_steps = steps_in(seconds, read_table(speed), width)
    options = {**training, "checkpoint": checkpoint, "events": events}
    options["settings"] = {**training["settings"], "width": width, "n_steps": n_steps}
    options["validation"] = {**training["validation"], "every_steps": max(1, n_steps // N_VALIDATIONS)}
    train_cgan(train, generator, losses, scores, samples, **options)


run(train_width)
