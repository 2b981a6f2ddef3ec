import re
import tomllib
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[1]
CONDA_NAMES = {"matplotlib-base": "matplotlib", "pytorch": "torch"}
CONDA = dict(
    entry.split("=")
    for entry in yaml.safe_load((ROOT / "envs/cpu.yaml").read_text())["dependencies"]
)
PINS = {CONDA_NAMES.get(name, name): version for name, version in CONDA.items()}


def test_conda_pins_equal_the_lock_file_and_hold_every_dependency():
    pins = re.findall(
        r"^([a-z0-9-]+)==([^ ]+)", (ROOT / "requirements.lock").read_text(), flags=re.MULTILINE
    )
    torch = re.search(
        r"^TORCH_VERSION := (\S+)", (ROOT / "Makefile").read_text(), flags=re.MULTILINE
    )
    # A post-release rebuilds the same source; conda numbers builds apart.
    locked = {name: version.split(".post")[0] for name, version in pins} | {
        "torch": torch[1],
        "python": "3.11",
    }
    assert {name: locked[name] for name in {*PINS, "python"}} == PINS
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    declared = [*project["dependencies"], *extras["learn"], *extras["workflow"]]
    names = {re.match(r"[A-Za-z0-9-]+", entry)[0].lower() for entry in declared} - {"snakemake"}
    assert names <= set(PINS)
