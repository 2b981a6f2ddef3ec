"""Train the cGAN at one width, for as many steps as the other widths or for as much processor time."""

from job import job
from train_cgan import train

from snowsim.io.files import read_table

N_VALIDATIONS = 4


def steps_of(path_to_speed, width, mode, n_steps, seconds):
    """Steps that a training of this width takes."""
    if mode == "equal_steps":
        return n_steps
    speed = read_table(path_to_speed)
    of_width = speed[(speed["method"] == "cgan") & (speed["width"] == width) & (speed["work"] == "step")]
    return max(1, round(seconds / of_width["seconds"].median()))


def train_width(
    paths_to_train, path_to_speed, paths_to_outputs, mode, width, n_steps, seconds, training, checkpoint, events
):  # fmt: skip
    n_steps = steps_of(path_to_speed, width, mode, n_steps, seconds)
    changed = {
        "settings": {**training["settings"], "width": width, "n_steps": n_steps},
        "validation": {**training["validation"], "every_steps": max(1, n_steps // N_VALIDATIONS)},
    }
    train(paths_to_train, *paths_to_outputs, **{**training, **changed}, checkpoint=checkpoint, events=events)


if __name__ == "__main__":
    with job(snakemake):
        train_width(snakemake.input.train, snakemake.input.speed, snakemake.output, **snakemake.params)
