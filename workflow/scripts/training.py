"""What the scripts that train networks share: unfinished trainings on disk, logs, validation, progress.

A script makes its training, opens a `TrainingRun` of it, takes the steps through it and writes its files before that
closes::

    with TrainingRun(training, path_to_checkpoint, expected, every_steps=500, path_to_events=path) as run:
        run.take(train_steps(training, scenes), settings.n_steps, "cGAN")
        write_table(path_to_losses, run.losses())
        write_model(path_to_network, training.state()["network"], metadata)

Killed at any moment, the script goes on from the last checkpoint when it is run again, and its files are the same to
the byte. The checkpoint goes when the block ends well. It is no declared output: Snakemake removes those of a failed
job.
"""

import logging
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import torch
from job import available_memory_mb, progress
from torch.utils.tensorboard import SummaryWriter

from snowsim import __version__
from snowsim.io.models import read_model, write_model
from snowsim.training import on_cpu

LOGGED_EVERY = 10  # [steps] to TensorBoard
SHOWN_EVERY = 50  # [steps] beside the progress bar

logger = logging.getLogger("snowsim")


@dataclass(frozen=True)
class Validation:
    """Scores of a training on scenes it does not train on, taken as it goes.

    Attributes
    ----------
    every_steps : int
        Steps between two validations; there is one after the last step too.
    score : callable
        () -> dict of float; of the training as it is. Must draw its random numbers from streams of its own.
    weights : callable
        () -> dict of arrays or tensors to keep of the best: what is to be written in the end.
    by : str
        The score to go by; higher is better.
    samples : callable, optional
        () -> dict of arrays to keep of every validation, called after `score`.
    patience : int, optional
        Validations in a row without a better score after which training stops; None never stops it.
    """

    every_steps: int
    score: Callable[[], dict]
    weights: Callable[[], dict]
    by: str
    patience: int | None = None
    samples: Callable[[], dict] = dict


class TrainingRun:
    """One training with its checkpoint, losses, validations and logs; to be used as a context.

    Parameters
    ----------
    training
        Has `step`, `state()` and `restore(state, step)`, as `snowsim.cgan.Training` and `snowsim.tracker.Training` do.
    path_to_checkpoint : path_like
        `.safetensors`; continued where it exists, removed when the context ends without an exception.
    expected : dict
        What made the training, as JSON holds it: kind, settings, seed, fingerprint of the data. A checkpoint that says
        something else is refused.
    every_steps : int
        Steps between checkpoints: as many are lost at most.
    path_to_events : path_like, optional
        Folder of TensorBoard's event files; None writes none.
    validation : Validation, optional

    Attributes
    ----------
    best : dict of arrays, or None
        The weights that `validation` kept, after `best_step` steps.
    samples : dict
        Step -> what `validation` kept of it.

    Raises
    ------
    ValueError
        On entry, in one line, if the checkpoint is truncated or another configuration made it.
    """

    def __init__(
        self, training, path_to_checkpoint, expected, *, every_steps, path_to_events=None, validation=None
    ):  # fmt: skip
        self.training, self.validation, self.every_steps = training, validation, every_steps
        self.best, self.best_step, self.samples = None, 0, {}
        self._path, self._events_path = Path(path_to_checkpoint), path_to_events
        self._expected = {**expected, "version": __version__}
        self._losses, self._scores = [], []
        self._events = None

    def __enter__(self):
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
        """Forget the checkpoint: what is to come of the training is known, and no better for another try."""
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
        patience = None if self.validation is None else self.validation.patience
        return patience is not None and sum(row["step"] > self.best_step for row in self._scores) >= patience

    def take(self, steps, n_steps, description):
        """Take the steps that are left, or fewer if validation stalls.

        Parameters
        ----------
        steps : iterator of (int, dict of float)
            `train_steps(training, ...)`, not begun.
        n_steps : int
            Number of the last step.
        description : str
            Stands before the progress bar.
        """
        bar = progress(None, description, total=n_steps, initial=self.training.step)
        while not self.has_stalled:
            step, losses = next(steps, (None, None))
            if step is None:
                break
            self._losses.append({"step": step, **losses})
            self._log("loss", losses, step, every=LOGGED_EVERY)
            if step % SHOWN_EVERY == 0:
                bar.set_postfix({name: f"{value:.4g}" for name, value in losses.items()}, refresh=False)
            bar.update()
            if self.validation is not None and (step % self.validation.every_steps == 0 or step == n_steps):
                self._validate(step)
            if step % self.every_steps == 0 and step < n_steps:
                self._save(step)
        bar.close()
        if self.has_stalled:
            logger.info("stopped after %d steps: none better since step %d", self.training.step, self.best_step)

    def _validate(self, step):
        scores = self.validation.score()
        best_before = max((row[self.validation.by] for row in self._scores), default=-np.inf)
        self._scores.append({"step": step, **scores})
        self._log("validation", scores, step)
        logger.info("step %d: %s", step, ", ".join(f"{name} {value:.4g}" for name, value in scores.items()))
        self.samples[step] = self.validation.samples()
        if scores[self.validation.by] > best_before:
            # A copy: the weights go on changing.
            self.best = {name: np.asarray(w).copy() for name, w in on_cpu(self.validation.weights()).items()}
            self.best_step = step

    def _save(self, step):
        arrays = {
            "training": self.training.state(),
            "losses": _columns(self._losses),
            "scores": _columns(self._scores),
            "best": self.best or {},
            "samples": self.samples,
        }
        columns = {"losses": list(self._losses[0]), "scores": list(self._scores[0]) if self._scores else []}
        metadata = {**self._expected, "step": step, "best_step": self.best_step, "columns": columns}
        write_model(self._path, arrays, metadata)

    def _resume(self):
        try:
            arrays, metadata = read_model(self._path, self._expected)
        except ValueError as error:
            msg = f"{error}; an unfinished training is kept there: remove it to begin anew"
            raise ValueError(msg) from error
        self.training.restore(arrays["training"], metadata["step"])
        self._losses, self._scores = (
            _rows(arrays.get(table, {}), names) for table, names in sorted(metadata["columns"].items())
        )
        self.best, self.best_step = arrays.get("best"), metadata["best_step"]
        samples = {int(step): kept for step, kept in arrays.get("samples", {}).items()}
        self.samples = dict(sorted(samples.items()))
        logger.info("goes on from %s after %d steps", self._path, metadata["step"])

    def _log(self, group, values, step, every=1):
        if self._events is not None and step % every == 0:
            for name, value in values.items():
                self._events.add_scalar(f"{group}/{name}", value, step)


@contextmanager
def enough_memory(what):
    """Turn a failed allocation into one line that names `what` was too large."""
    try:
        yield
    except (MemoryError, RuntimeError) as error:
        said = str(error).splitlines()[0] if str(error) else "no memory left"
        out_of_memory = isinstance(error, MemoryError | torch.OutOfMemoryError) or "allocate memory" in said
        if not out_of_memory:
            raise
        msg = f"too little memory for {what}: {said[:200]}"
        raise ValueError(msg) from error


def check_memory(n_bytes, what):
    """Raise ValueError in one line if the machine cannot hold `n_bytes` now; machines that do not say pass."""
    available = available_memory_mb()
    if available is not None and n_bytes > available * 2**20:
        needed, free = n_bytes / 1e9, available * 2**20 / 1e9
        msg = f"too little memory for {what}: it needs at least {needed:.3g} GB, {free:.3g} GB are free"
        raise ValueError(msg)


def _columns(rows):
    """Rows of numbers as one array a column."""
    return {name: np.array([row[name] for row in rows]) for name in (rows[0] if rows else {})}


def _rows(columns, names):
    """The inverse of `_columns`, given the order of the columns."""
    return [dict(zip(names, values, strict=True)) for values in zip(*(columns[n].tolist() for n in names), strict=True)]
