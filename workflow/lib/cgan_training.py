"""A training of the conditional GAN: on what, and what it leaves."""

import logging
from dataclasses import asdict

import numpy as np
from torch.utils.data import Subset

from lib.training import TrainingRun, check_memory, enough_memory
from snowsim.cgan import Settings, Training, least_bytes, train_steps
from snowsim.cgan.fades import fade_spread
from snowsim.cgan.scope import scope_of
from snowsim.io.files import write_table
from snowsim.io.models import fingerprint, write_model
from snowsim.io.scenes import SceneSet
from snowsim.patches import draw_index

UNDECIDED = np.log(2)  # loss of a discriminator that always says one half
WINDOW_STEPS = 200  # the loss of one step scatters by about a half: a mean over these by 0.04
# Below a tenth of the undecided loss it is right with 93 % confidence everywhere: its gradient for
# the generator is mostly noise.
SATURATED = 0.1

logger = logging.getLogger("snowsim")


def train(
    scenes, generator, losses,
    *, settings, seed, device, n_held, checkpoint, checkpoint_steps, events,
):  # fmt: skip
    """Train on files of scenes, from the checkpoint where there is one."""
    settings = Settings(**settings)
    what = f"a cGAN of width {settings.width}"
    check_memory(least_bytes(settings), what)
    made_of = {
        "settings": asdict(settings),
        "seed": seed,
        "n_held": n_held,
        "data": fingerprint(scenes),
    }
    with SceneSet(scenes) as observed, enough_memory(what):
        trained_on = Subset(observed, not_held_out(len(observed), n_held, seed=seed))
        training = Training(settings, seed=seed, device=device)
        unfinished = {"kind": "unfinished cgan training", **made_of}
        kept = {"every_steps": checkpoint_steps, "path_to_events": events}
        with TrainingRun(training, checkpoint, unfinished, **kept) as taken:
            taken.take(train_steps(training, trained_on), settings.n_steps, "cGAN")
            note_saturation(taken.losses())
            metadata = {
                "kind": "cgan generator",
                **made_of,
                "step": training.step,
                "scope": scope_of(trained_on),
                "fade_spread": fade_spread(trained_on),
            }
            # Within the block: only a training whose files are written needs no checkpoint.
            write_table(losses, taken.losses())
            write_model(generator, training.state()["generator"], metadata)


def not_held_out(n_scenes, n_held, *, seed):
    """Numbers of the scenes to train on, sorted; ValueError if none is left."""
    if n_held >= n_scenes:
        msg = f"n_held: {n_held} train scenes are held out, there are {n_scenes}: "
        msg += "none is left to train on"
        raise ValueError(msg)
    held = {draw_index(n_scenes, position, seed, "cgan", "held out") for position in range(n_held)}
    return [number for number in range(n_scenes) if number not in held]


def note_saturation(losses):
    """Log the discriminator's late loss by that of an undecided one; warn where little is left."""
    late = losses.tail(WINDOW_STEPS)
    if "discriminator_real" not in late:
        return
    mean = late[["discriminator_real", "discriminator_fake"]].mean(axis=None)
    share = mean / UNDECIDED
    logger.info("discriminator: late loss %.3f of an undecided one's", share)
    if share < SATURATED:
        logger.warning("discriminator saturated: below %g, the generator learns little", SATURATED)
