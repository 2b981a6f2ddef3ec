"""The conda environment names the versions that are pinned and tested."""

import re
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[1]
CONDA_NAMES = {"matplotlib-base": "matplotlib", "pytorch": "torch"}


def locked_versions():
    pins = re.findall(r"^([a-z0-9-]+)==([^ ]+)", (ROOT / "requirements.lock").read_text(), flags=re.MULTILINE)
    torch = re.search(r"^TORCH_VERSION := (\S+)", (ROOT / "Makefile").read_text(), flags=re.MULTILINE)
    # A post-release rebuilds the same source; conda numbers builds apart.
    return {name: version.split(".post")[0] for name, version in pins} | {"torch": torch[1]}


def test_conda_pins_equal_the_lock_file():
    locked = locked_versions()
    pins = dict(entry.split("=") for entry in yaml.safe_load((ROOT / "envs/cpu.yaml").read_text())["dependencies"])
    assert pins.pop("python") == "3.11"
    assert pins == {name: locked[CONDA_NAMES.get(name, name)] for name in pins}


def test_every_dependency_of_the_package_is_in_the_conda_environment():
    import tomllib

    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    names = {re.match(r"[A-Za-z0-9-]+", entry)[0].lower() for entry in declared} - {"snakemake"}
    pins = {entry.split("=")[0] for entry in yaml.safe_load((ROOT / "envs/cpu.yaml").read_text())["dependencies"]}
    assert names <= {CONDA_NAMES.get(name, name) for name in pins}
