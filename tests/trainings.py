"""What tests of both networks' trainings share.

Taking steps, comparing states, killing a process midway.
"""

import os
import signal
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import torch
from toy_scenes import toy_scenes

from snowsim import cgan, tracker
from snowsim.io.files import read_table
from snowsim.io.models import read_model

torch.set_num_threads(1)  # as in every training
ROOT = Path(__file__).resolve().parents[1]
FILES = {"losses": "losses.csv", "checkpoint": "unfinished.safetensors", "events": "events"}
# Trains in a process of its own and tells every step it has taken.
CHILD = """
import sys, {module} as module
def steps_shown(*arguments, steps=module.train_steps):
    for step, losses in steps(*arguments):
        print(step, flush=True)
        yield step, losses
module.train_steps = steps_shown
module.train(**eval(sys.argv[1]))
"""


def begun(settings, seed=1, n_scenes=3):
    """A training of these settings, and its steps on toy scenes."""
    scenes = toy_scenes(n_scenes)
    if isinstance(settings, cgan.Settings):
        training = cgan.Training(settings, seed=seed)
        return training, cgan.train_steps(training, scenes)
    training = tracker.Training(settings, seed=seed)
    return training, tracker.train_steps(training, tracker.TrainingSet(scenes, seed=seed))


def trained(settings, seed=1, n_scenes=3):
    """A training that has taken its steps, and their losses."""
    training, steps = begun(settings, seed, n_scenes)
    return training, [losses for _, losses in steps]


def same(a, b):
    """Whether two nested states hold the same bits."""
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    return torch.equal(a, b)


def paths_in(folder, **files):
    """Arguments of a training that name its files in `folder`.

    Those of every training, and others.
    """
    return {name: str(folder / file) for name, file in (FILES | files).items()}


def check_killed_training(module, arguments, whole):
    """Kill the training of a module after 3.5 checkpoints and begin it again.

    Its files are those in `whole`.
    """
    checkpoint, every_steps = Path(arguments["checkpoint"]), arguments["checkpoint_steps"]
    n_steps = arguments["settings"]["n_steps"]
    names = {path.name for path in whole.iterdir() if path.is_file()}
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "workflow")])}
    command = [sys.executable, "-c", CHILD.format(module=module), repr(arguments)]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as child:
        for line in child.stdout:
            if int(line) >= 3.5 * every_steps:
                child.send_signal(signal.SIGKILL)
                break
    assert child.returncode == -signal.SIGKILL
    assert not names & {path.name for path in checkpoint.parent.iterdir()}
    _, metadata = read_model(checkpoint)
    assert 3 * every_steps <= metadata["step"] < n_steps
    import_module(module).train(**arguments)
    for name in names:
        assert (checkpoint.parent / name).read_bytes() == (whole / name).read_bytes()
    assert read_table(arguments["losses"])["step"].tolist() == list(range(1, n_steps + 1))
    assert not checkpoint.exists()
