import re
import tomllib

import yaml
from processes import ROOT


def read_text(name):
    return (ROOT / name).read_text()


def test_conda_pins_equal_the_lock_file_and_hold_every_dependency():
    entries = yaml.safe_load(read_text("envs/cpu.yaml"))["dependencies"]
    pins = dict(entry.split("=") for entry in entries)
    # By the names of PyPI.
    pins["matplotlib"] = pins.pop("matplotlib-base")
    pins["torch"] = pins.pop("pytorch")
    lock = re.findall(r"^([a-z0-9-]+)==([^ ]+)", read_text("requirements.lock"), flags=re.MULTILINE)
    torch = re.search(r"^TORCH_VERSION := (\S+)", read_text("Makefile"), flags=re.MULTILINE)
    # A post-release rebuilds the same source; conda numbers builds apart.
    locked = {name: version.split(".post")[0] for name, version in lock}
    locked["torch"] = torch[1]
    locked["python"] = "3.11"
    assert {name: locked[name] for name in pins} == pins
    project = tomllib.loads(read_text("pyproject.toml"))["project"]
    extras = project["optional-dependencies"]
    declared = [*project["dependencies"], *extras["learn"], *extras["workflow"]]
    names = {re.match(r"[A-Za-z0-9-]+", entry)[0].lower() for entry in declared}
    assert names - {"snakemake"} <= set(pins)
