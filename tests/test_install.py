"""The package builds, installs bare, and does there what its examples and README's scripts show."""

import re
import shutil
import sys
import tomllib
from functools import partial

import numpy as np
import pytest
from flights import frames_of
from numpy.testing import assert_array_equal
from processes import ROOT, run_in
from test_site import PUBLIC
from test_tutorial import NOT_COPIED, blocks

from snowsim.io import read_layers, write_dataset

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
EXTRAS = PROJECT["optional-dependencies"]
SCRIPTS = [code for language, code in blocks(ROOT / "README.md") if language == "python"]
NETWORKS = (
    "snowsim.cgan",
    "snowsim.tracker.network",
    "snowsim.tracker.portable",
    "snowsim.tracker.published",
    "snowsim.tracker.sampling",
    "snowsim.tracker.train",
    "snowsim.patches",
    "snowsim.training",
    "snowsim.learning",
)
# With these modules not to be had, import all others, then run the examples of the public
# functions.
EXAMPLES = """
import doctest, importlib, pkgutil, sys
class Blocked:
    def find_spec(name, path=None, target=None):
        if name.partition(".")[0] in {blocked}:
            raise ModuleNotFoundError("blocked: " + name)
sys.meta_path.insert(0, Blocked)
import snowsim
for module in pkgutil.walk_packages(snowsim.__path__, "snowsim.", onerror=lambda name: None):
    if not module.name.startswith({networks}):
        importlib.import_module(module.name)
runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
for name in {public}:
    module, _, function = name.rpartition(".")
    public = getattr(importlib.import_module(module), function)
    home = importlib.import_module(public.__module__)
    (example,) = doctest.DocTestFinder(recurse=False).find(public, name, module=home)
    assert example.examples, name + " has no example"
    runner.run(example)
sys.exit(runner.summarize().failed)
"""


def examples(blocked=()):
    return EXAMPLES.format(blocked=list(blocked), networks=NETWORKS, public=PUBLIC)


def test_the_core_needs_none_of_the_extras(tmp_path):
    names = [re.match(r"[\w-]+", entry)[0] for entry in EXTRAS["learn"] + EXTRAS["workflow"]]
    assert {"torch", "snakemake", "tensorboard", "zarr", "matplotlib"} <= set(names)
    blocked = [{"pyyaml": "yaml"}.get(name, name) for name in names]
    run_in(tmp_path, sys.executable, "-c", examples(blocked))


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Folder of the wheel and the source archive, made from a copy of the project."""
    folder = tmp_path_factory.mktemp("build") / "snowsim"
    shutil.copytree(ROOT, folder, ignore=NOT_COPIED, symlinks=True)
    made = "from setuptools import build_meta as b; b.build_wheel('made'); b.build_sdist('made')"
    run_in(folder, sys.executable, "-c", made)
    return folder / "made"


def bare(folder, what):
    """Python of a new environment that holds what is named and its requirements."""
    run_in(folder, sys.executable, "-m", "venv", "bare")
    run_in(folder, "bare/bin/python", "-m", "pip", "install", "--quiet", what)
    return folder / "bare/bin/python"


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["whl", "tar.gz"])
def test_what_is_built_works_in_a_bare_environment(built, tmp_path, monkeypatch, ending):
    monkeypatch.delenv("PYTHONPATH", raising=False)
    python = bare(tmp_path, next(built.glob(f"*.{ending}")))
    assert "torch" not in run_in(tmp_path, python, "-m", "pip", "list")
    run_in(tmp_path, python, "-I", "-c", examples())
    # Files of an example.
    scored = run_in(tmp_path, "bare/bin/snowsim", "score", "map.npy", "truth.npy")
    assert "all 1 images" in scored


def write_frames(folder):
    """Two frames of the reference flight with their table."""
    rows = ["frame\techogram\tlayers\trole"]
    frames = frames_of({"radar": {"n_range_bins": 1000}}, 2, 1024)
    for role, (echogram, layers) in zip(("statistics", "test"), frames, strict=True):
        write_dataset(folder / f"{role}_e.nc", echogram)
        write_dataset(folder / f"{role}_l.nc", layers)
        rows.append(f"{role}\t{role}_e.nc\t{role}_l.nc\t{role}")
    (folder / "frames.tsv").write_text("\n".join(rows))


@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(SCRIPTS)))
def test_the_readme_s_scripts_run_with_what_they_say_they_need(
    built, tmp_path, monkeypatch, number
):
    monkeypatch.delenv("PYTHONPATH", raising=False)
    needed = SCRIPTS[number].splitlines()[0]
    extra = re.fullmatch(r"# pip install \"?\.(\[\w+\])?\"?", needed)[1] or ""
    write_frames(tmp_path)
    python = bare(tmp_path, f"{next(built.glob('*.whl'))}{extra}")
    # The first of README's commands: a script reads what it makes.
    run_in(tmp_path, "bare/bin/snowsim", "simulate", "echogram.nc")
    (tmp_path / "script.py").write_text(SCRIPTS[number])
    assert run_in(tmp_path, python, "-I", "script.py").strip()


# xopr reads the layer file that it is given.
XOPR = """
import sys
import numpy as np
from xopr.opr_access import OPRConnection
connection = OPRConnection(stac_parquet_href="none.parquet", sync_catalogs=False)
np.save("xopr.npy", connection.load_layers_file(sys.argv[1])["twtt"].values)
"""


@pytest.mark.slow
def test_one_tracks_without_torch_what_others_read_and_trains_with_it(built, tmp_path, monkeypatch):
    write_frames(tmp_path)
    monkeypatch.delenv("PYTHONPATH", raising=False)
    wheel = next(built.glob("*.whl"))
    bare(tmp_path, wheel)
    pip = partial(run_in, tmp_path, "bare/bin/python", "-m", "pip")
    run = partial(run_in, tmp_path, "bare/bin/snowsim")
    pip("install", "-q", f"{wheel}[track]")
    assert "torch" not in pip("list")
    run("track", "test_e.nc", "-o", "shipped")
    pip("install", "-q", "xopr==0.6.0")
    [layer_file] = tmp_path.glob("shipped/CSARP_layer/*/Data_*.mat")
    run_in(tmp_path, "bare/bin/python", "-c", XOPR, layer_file)
    assert_array_equal(np.load(tmp_path / "xopr.npy"), read_layers(layer_file)["twtt"])
    # The CPU build of torch first, as README says; then what else `learn` needs.
    version, index = (
        re.search(rf"^{name} \S*= (\S+)", (ROOT / "Makefile").read_text(), re.MULTILINE)[1]
        for name in ("TORCH_VERSION", "TORCH_INDEX")
    )
    run_in(tmp_path, "bare/bin/python", ROOT / "envs/install_torch.py", version, index)
    pip("install", "-q", "onnx", "safetensors")
    run("scenes", "drawn", "-n", 30, "--range-bins", 400)
    run("train", "drawn", "-o", "mine.onnx", "--from", "universal", "--steps", 20)
    run("track", "test_e.nc", "-o", "picked", "--model", "mine.onnx")
    assert list(tmp_path.glob("picked/*_layers.nc"))
