"""Commands run in processes of their own, and the project's folder."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def run_in(folder, *command):
    """What a command prints that ends well, run in a folder."""
    words = [str(word) for word in command]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{command}:\n{done.stdout[-2000:]}\n{done.stderr[-3000:]}"
    return done.stdout
