"""In an environment of its own, without torch, the command tracks what others then read."""

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from planted_layers import BIN_S, WRITERS, content_of, planted
from processes import run_in

from snowsim.io import read_layers
from snowsim.io.pairs import write_image

ROOT = Path(__file__).resolve().parents[2]
SEGMENT_OF = {"mat73": "20120330_04", "nsidc": "20120330_05", "opr": "20120330_06"}
MOST_MB = 180  # that the extra may add: onnxruntime, and matplotlib with 56
XOPR = """
import sys
import numpy as np
from xopr.opr_access import OPRConnection
connection = OPRConnection(stac_parquet_href="none.parquet", sync_catalogs=False)
for number, path in enumerate(sys.argv[1:]):
    layers = connection.load_layers_file(path)
    np.save(f"xopr_{number}.npy", layers["twtt"].values)
"""


def megabytes(folder):
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) / 1e6


@pytest.fixture(scope="module")
def environment(tmp_path_factory):
    """Folder `bin` of an environment with the package, the extra `track` and xopr."""
    folder = tmp_path_factory.mktemp("environment")
    copied = folder / "snowsim"
    shutil.copytree(ROOT / "snowsim", copied / "snowsim")
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, copied / name)
    run_in(folder, sys.executable, "-m", "venv", "bare")
    pip = (folder / "bare/bin/python", "-m", "pip", "install", "--quiet", "--no-compile")
    run_in(folder, *pip, copied)
    before = megabytes(folder / "bare/lib")
    run_in(folder, *pip, f"{copied}[track]")
    added = megabytes(folder / "bare/lib") - before
    assert added < MOST_MB, f"the extra adds {added:.0f} MB"
    assert "torch" not in run_in(folder, folder / "bare/bin/python", "-m", "pip", "list")
    run_in(folder, *pip, "xopr==0.6.0")
    return folder / "bare/bin"


@pytest.mark.slow
def test_layers_tracked_in_a_fresh_environment_are_read_by_all(
    environment, weights, tmp_path, rng, monkeypatch
):
    monkeypatch.delenv("PYTHONPATH", raising=False)
    echogram, _ = planted(rng)
    content = content_of(echogram)
    echograms = []
    for kind, segment in SEGMENT_OF.items():
        name, write = WRITERS[kind]
        path = tmp_path / name.replace("20120330_04", segment)
        write(path, content)
        echograms.append(path)
    image = tmp_path / "scene.png"
    rows = np.log10(echogram["Data"].values)
    write_image(image, np.clip(60 + 60 * rows, 0, 255).astype(np.uint8))
    options = ("-o", tmp_path / "out", "--model", weights, "--bin-s", BIN_S)
    snowsim = environment / "snowsim"
    said = run_in(tmp_path, snowsim, "track", *echograms, image, *options)
    assert said.count("4 layers below the surface") == 4
    layer_files = []
    for path, segment in zip(echograms, SEGMENT_OF.values(), strict=True):
        layer_files.append(tmp_path / f"out/CSARP_layer/{segment}/Data_{segment}_001.mat")
        told = run_in(tmp_path, snowsim, "info", layer_files[-1])
        assert "snow_4" in told
        assert "snow_4" in run_in(tmp_path, snowsim, "info", _netcdf(tmp_path, path))
    assert "snow_4" in run_in(tmp_path, snowsim, "info", _netcdf(tmp_path, image))
    run_in(tmp_path, environment / "python", "-c", XOPR, *layer_files)
    for number, (path, layer_file) in enumerate(zip(echograms, layer_files, strict=True)):
        twtt = read_layers(_netcdf(tmp_path, path))["twtt"].values
        assert np.array_equal(twtt, read_layers(layer_file)["twtt"], equal_nan=True)
        assert np.array_equal(twtt, np.load(tmp_path / f"xopr_{number}.npy"), equal_nan=True)


def _netcdf(folder, path):
    return folder / "out" / f"{Path(path).stem}_layers.nc"
