"""A training of the conditional GAN: on what, and what it leaves."""

import logging
from dataclasses import asdict

import numpy as np

from lib.training import TrainingRun, check_memory, enough_memory
from snowsim.cgan import Settings, Training, least_bytes, train_steps
from snowsim.io.files import write_table
from snowsim.io.models import fingerprint, write_model
from snowsim.io.scenes import SceneSet

# What files of generators must say; raise the number where older weights mean something else.
GENERATOR = {"kind": "cgan generator 2"}
UNDECIDED = np.log(2)  # loss of a discriminator that always says one half
WINDOW_STEPS = 200  # the loss of one step scatters by about a half: a mean over these by 0.04
# Below a tenth of the undecided loss it is right with 93 % confidence everywhere: its gradient for
# the generator is mostly noise.
SATURATED = 0.1

logger = logging.getLogger("snowsim")


def train(scenes, generator, losses, *, settings, seed, device, threads=1, **kept):
    """Train on files of scenes, from the checkpoint where there is one; leave the last weights.

    Threads beside the first prepare inputs. `kept` are the options of `TrainingRun`.
    """
    settings = Settings(**settings)
    what = f"a cGAN of width {settings.width}"
    check_memory(least_bytes(settings), what)
    made_of = {"settings": asdict(settings), "seed": seed, "data": fingerprint(scenes)}
    with SceneSet(scenes) as observed, enough_memory(what):
        training = Training(settings, seed=seed, device=device)
        unfinished = {"kind": "unfinished cgan training", **made_of}
        steps = train_steps(training, observed, n_workers=threads - 1)
        with TrainingRun(training, unfinished, **kept) as taken:
            taken.take(steps, settings.n_steps, "cGAN")
            note_saturation(taken.losses())
            # Within the block: only a training whose files are written needs no checkpoint.
            write_table(losses, taken.losses())
            weights = training.state()["generator"]
            write_model(generator, weights, {**GENERATOR, **made_of, "step": training.step})


def note_saturation(losses):
    """Log the discriminator's late loss by that of an undecided one; warn where little is left."""
    late = losses.tail(WINDOW_STEPS)
    mean = late[["discriminator_real", "discriminator_fake"]].mean(axis=None)
    share = mean / UNDECIDED
    logger.info("discriminator: late loss %.3f of an undecided one's", share)
    if share < SATURATED:
        logger.warning("discriminator saturated: below %g, the generator learns little", SATURATED)
