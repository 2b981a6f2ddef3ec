"""Trainings that go on from their last checkpoint and end with the same bytes.

A checkpoint is not a declared output, because Snakemake removes the outputs of a failed job.
"""

import logging
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
import psutil
import torch
from torch.utils.tensorboard import SummaryWriter

from lib.progress import progress
from snowsim import __version__
from snowsim.io.models import read_model, write_model

LOGGED_EVERY = 10  # [steps] between events for TensorBoard
SHOWN_EVERY = 50  # [steps] between losses beside the progress bar

logger = logging.getLogger("snowsim")


class TrainingRun:
    """A training with its checkpoint, losses and logs, as a context.

    `checkpoint` is a `.safetensors` file, written every `checkpoint_steps` steps. `expected`
    describes the training, in values that JSON can hold; ValueError on entry if the checkpoint
    describes another one or is truncated. The checkpoint is removed when the block ends well, and
    when a loss is not finite, since another try would end alike. `events` is a folder for those of
    TensorBoard.
    """

    def __init__(self, training, expected, *, checkpoint, checkpoint_steps, events):
        self.training = training
        self._path = Path(checkpoint)
        self._every_steps = checkpoint_steps
        self._events_path = events
        self._expected = {**expected, "version": __version__}
        self._losses = []

    def __enter__(self):
        # As the workflow does, so that a training called from elsewhere ends with the same bytes.
        torch.set_num_threads(1)
        if self._path.exists():
            self._resume()
        # Steps after the checkpoint are taken again, so their events are removed.
        self._events = SummaryWriter(self._events_path, purge_step=self.training.step + 1)
        return self

    def __exit__(self, kind, *exception):
        self._events.close()
        if kind in (None, FloatingPointError):
            self._path.unlink(missing_ok=True)

    def losses(self):
        """Losses of every step since the first, also of steps before a resume, a row for each."""
        return pd.DataFrame(self._losses)

    def take(self, steps, n_steps, description):
        """Take the remaining `steps` of `n_steps` beside a progress bar."""
        bar = progress(None, description, total=n_steps, initial=self.training.step)
        saved = self.training.step
        for step, losses in steps:
            self._losses.append({"step": step, **losses})
            if step % LOGGED_EVERY == 0:
                for name, value in losses.items():
                    self._events.add_scalar(f"loss/{name}", value, step)
            if step % SHOWN_EVERY == 0:
                shown = ", ".join(f"{name}={value:.4g}" for name, value in losses.items())
                bar.set_postfix_str(shown, refresh=False)
            bar.update(step - bar.n)
            # Steps come one by one, on a GPU several at a time.
            if step // self._every_steps > saved // self._every_steps and step < n_steps:
                self._save(step)
                saved = step
        bar.close()

    def _save(self, step):
        table = self.losses()
        losses = {name: np.array(table[name]) for name in table}
        arrays = {"training": self.training.state(), "losses": losses}
        columns = list(table)  # the file sorts them
        metadata = {**self._expected, "step": step, "columns": columns}
        write_model(self._path, arrays, metadata)

    def _resume(self):
        try:
            arrays, metadata = read_model(self._path, self._expected)
        except ValueError as error:
            msg = f"{error}; an unfinished training is kept there: remove it to begin anew"
            raise ValueError(msg) from error
        self.training.restore(arrays["training"], metadata["step"])
        losses = pd.DataFrame(arrays["losses"], columns=metadata["columns"])
        self._losses = losses.to_dict("records")
        logger.info("goes on from %s after %d steps", self._path, metadata["step"])


@contextmanager
def enough_memory(what):
    """Turn a failed allocation into a ValueError of one line, which names `what` was too large."""
    try:
        yield
    except (MemoryError, RuntimeError) as error:
        reason = (str(error) or "no memory left").splitlines()[0]
        is_memory = isinstance(error, MemoryError | torch.OutOfMemoryError)
        if not is_memory and "allocate memory" not in reason:
            raise
        msg = f"too little memory for {what}: {reason[:200]}"
        raise ValueError(msg) from error


def check_memory(n_bytes, what):
    """ValueError of one line if the machine has less than `n_bytes` of free memory."""
    n_free = psutil.virtual_memory().available
    if n_bytes > n_free:
        needed = f"it needs at least {n_bytes / 1e9:.3g} GB, {n_free / 1e9:.3g} GB are free"
        msg = f"too little memory for {what}: {needed}"
        raise ValueError(msg)
