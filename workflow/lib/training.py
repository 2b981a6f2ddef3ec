"""Trainings that go on from their last checkpoint, to the same bytes, with logs and validations.

A checkpoint is no declared output, for Snakemake removes those of a failed job.
"""

import logging
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
import torch
from torch.utils.tensorboard import SummaryWriter

from lib.progress import available_memory_mb, progress
from snowsim import __version__
from snowsim.io.models import read_model, write_model
from snowsim.training import on_cpu

LOGGED_EVERY = 10  # [steps] to TensorBoard
SHOWN_EVERY = 50  # [steps] beside the progress bar

logger = logging.getLogger("snowsim")


class TrainingRun:
    """One training with its checkpoint, losses, validations and logs.

    A context in which its files are written.

    `expected` is what made it, as JSON holds it; ValueError on entry if the checkpoint
    (`.safetensors`, every `every_steps`) says something else or is truncated; it goes when the
    block ends well. Events for TensorBoard go to the folder `path_to_events`. `validation` has
    `score` every `every_steps` and after the last step, `weights` to keep of the `best`, highest in
    `by`, and `samples` of each; `patience` of them without a better one end the training.
    """

    def __init__(
        self,
        training,
        path_to_checkpoint,
        expected,
        *,
        every_steps,
        path_to_events=None,
        validation=None,
    ):
        self.training = training
        self.validation = validation
        self.every_steps = every_steps
        self.best = None
        self.best_step = 0
        self.samples = {}
        self._path = Path(path_to_checkpoint)
        self._events_path = path_to_events
        self._expected = {**expected, "version": __version__}
        self._losses = []
        self._scores = []
        self._events = None

    def __enter__(self):
        # The workflow gives every process one thread; a training called by anyone else ends with
        # the same bytes.
        torch.set_num_threads(1)
        if self._path.exists():
            self._resume()
        if self._events_path is not None:
            # Events beyond the checkpoint were written by steps that are taken again.
            self._events = SummaryWriter(self._events_path, purge_step=self.training.step + 1)
        return self

    def __exit__(self, kind, *exception):
        if self._events is not None:
            self._events.close()
        if kind is None:
            self._path.unlink(missing_ok=True)

    def discard(self):
        """Forget the checkpoint.

        What is to come of the training is known, and no better for another try.
        """
        self._path.unlink(missing_ok=True)

    def losses(self):
        """Losses of every step since the first, those before a resume included: a row a step."""
        return pd.DataFrame(self._losses)

    def late_losses(self, n):
        """Losses of the last `n` steps, a dict a step."""
        return self._losses[-n:]

    def scores(self):
        """Scores of every validation since the first step: a row each."""
        return pd.DataFrame(self._scores)

    @property
    def has_stalled(self):
        """Whether the last `patience` validations brought nothing better."""
        if self.validation is None or self.validation.patience is None:
            return False
        n_since_best = sum(row["step"] > self.best_step for row in self._scores)
        return n_since_best >= self.validation.patience

    def take(self, steps, n_steps, description):
        """Take the `steps` left of `n_steps`, fewer if validation stalls, beside a progress bar."""
        bar = progress(None, description, total=n_steps, initial=self.training.step)
        while not self.has_stalled:
            step, losses = next(steps, (None, None))
            if step is None:
                break
            self._losses.append({"step": step, **losses})
            self._log("loss", losses, step, every=LOGGED_EVERY)
            if step % SHOWN_EVERY == 0:
                bar.set_postfix_str(_in_words(losses, "="), refresh=False)
            bar.update()
            if self.validation is not None:
                is_due = step % self.validation.every_steps == 0
                if is_due or step == n_steps:
                    self._validate(step)
            if step % self.every_steps == 0 and step < n_steps:
                self._save(step)
        bar.close()
        if self.has_stalled:
            message = "stopped after %d steps: none better since step %d"
            logger.info(message, self.training.step, self.best_step)

    def _validate(self, step):
        scores = self.validation.score()
        best_before = max((row[self.validation.by] for row in self._scores), default=-np.inf)
        self._scores.append({"step": step, **scores})
        self._log("validation", scores, step)
        logger.info("step %d: %s", step, _in_words(scores, " "))
        self.samples[step] = self.validation.samples()
        if scores[self.validation.by] > best_before:
            weights = on_cpu(self.validation.weights())
            # A copy: the weights go on changing.
            self.best = {name: np.asarray(values).copy() for name, values in weights.items()}
            self.best_step = step

    def _save(self, step):
        tables = {"losses": self.losses(), "scores": self.scores()}
        arrays = {
            "training": self.training.state(),
            "best": self.best or {},
            "samples": self.samples,
        }
        for kind, table in tables.items():
            arrays[kind] = {name: np.array(table[name]) for name in table}
        columns = {kind: list(table) for kind, table in tables.items()}  # the file sorts them
        metadata = {**self._expected, "step": step, "best_step": self.best_step, "columns": columns}
        write_model(self._path, arrays, metadata)

    def _resume(self):
        try:
            arrays, metadata = read_model(self._path, self._expected)
        except ValueError as error:
            msg = f"{error}; an unfinished training is kept there: remove it to begin anew"
            raise ValueError(msg) from error
        self.training.restore(arrays["training"], metadata["step"])
        columns = metadata["columns"]
        self._losses = _rows(arrays.get("losses", {}), columns["losses"])
        self._scores = _rows(arrays.get("scores", {}), columns["scores"])
        self.best = arrays.get("best")
        self.best_step = metadata["best_step"]
        samples = {int(step): kept for step, kept in arrays.get("samples", {}).items()}
        self.samples = dict(sorted(samples.items()))
        logger.info("goes on from %s after %d steps", self._path, metadata["step"])

    def _log(self, group, values, step, every=1):
        if self._events is not None and step % every == 0:
            for name, value in values.items():
                self._events.add_scalar(f"{group}/{name}", value, step)


def _rows(arrays, columns):
    return pd.DataFrame(arrays, columns=columns).to_dict("records")


def _in_words(values, between):
    return ", ".join(f"{name}{between}{value:.4g}" for name, value in values.items())


@contextmanager
def enough_memory(what):
    """Turn a failed allocation into one line that names `what` was too large."""
    try:
        yield
    except (MemoryError, RuntimeError) as error:
        said = str(error).splitlines()[0] if str(error) else "no memory left"
        known = isinstance(error, MemoryError | torch.OutOfMemoryError)
        if not known and "allocate memory" not in said:
            raise
        msg = f"too little memory for {what}: {said[:200]}"
        raise ValueError(msg) from error


def check_memory(n_bytes, what):
    """Raise ValueError in one line if the machine cannot hold `n_bytes` now.

    Machines that do not say pass.
    """
    available_mb = available_memory_mb()
    if available_mb is None:
        return
    n_free = available_mb * 2**20
    if n_bytes > n_free:
        needed = f"it needs at least {n_bytes / 1e9:.3g} GB, {n_free / 1e9:.3g} GB are free"
        msg = f"too little memory for {what}: {needed}"
        raise ValueError(msg)
