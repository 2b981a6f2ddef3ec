"""What tests of both networks' trainings share: comparing states, killing a script midway."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import torch

ROOT = Path(__file__).resolve().parents[1]
# Runs a script in a process of its own and tells every step it has taken.
CHILD = """
import sys, {script} as script
def told(training, scenes, steps=script.train_steps):
    for step, losses in steps(training, scenes):
        print(step, flush=True)
        yield step, losses
script.train_steps = told
script.train(**eval(sys.argv[1]))
"""


def same(a, b):
    """Whether two nested states hold the same bits."""
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    return torch.equal(a, b)


def kill_midway(script, arguments, n_steps):
    """Kill the training of a script once it has taken so many steps; the last step it told."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "workflow/scripts")])}
    command = [sys.executable, "-c", CHILD.format(script=script), repr(arguments)]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as child:
        for line in child.stdout:
            if int(line) >= n_steps:
                child.send_signal(signal.SIGKILL)
                break
        last_told = max([int(line), *map(int, child.stdout.read().split())])
    assert child.returncode == -signal.SIGKILL
    return last_told
