"""Three newcomers, each with their own files and the wheel in an environment of their own."""

import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from test_install import bare, built, run_in, write_frames  # noqa: F401

from snowsim.io.files import write_dataset
from snowsim.reference import checked_settings, draw_climate, draw_frame

ROOT = Path(__file__).resolve().parents[1]
pytestmark = pytest.mark.slow

PIT = """depth [cm],density [g cm-3]
0,0.32
8,0.35
8.5,0.60
9,0.36
40,
55,0.39
120,0.42
"""
# Statistics of one's own frames, with what `fit` warns of; scenes drawn from them.
OWN = """
import sys, warnings
from snowsim import scenes
from snowsim.io.files import write_dataset
from snowsim.io.frame_table import each_frame, read_frames
from snowsim.statistics import fit

with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    try:
        statistics = fit(each_frame(read_frames("frames.tsv"), "statistics"))
    except ValueError as error:
        print(1)
        print("refused", error)
        sys.exit()
write_dataset("statistics.nc", statistics)
print(len([w for w in caught if "too few" in str(w.message) or "needed" in str(w.message)]))
try:
    image, mask = scenes(5, statistics="statistics.nc", rng=1)[0]
    print("drawn", image.shape, int(mask.any()))
except ValueError as error:
    print("refused", error)
"""


@pytest.fixture
def snowsim(built, tmp_path, monkeypatch):  # noqa: F811
    """Run the command of a bare environment, with an extra, in the test's folder."""
    monkeypatch.delenv("PYTHONPATH", raising=False)

    def installed(extra=""):
        bare(tmp_path, f"{next(built.glob('*.whl'))}{extra}")
        return lambda *words: run_in(tmp_path, "bare/bin/snowsim", *words)

    return installed


def test_one_simulates_a_radar_over_a_pit(snowsim, tmp_path):
    (tmp_path / "pit.csv").write_text(PIT)
    run = snowsim()
    run("simulate", "pit.nc", "--profile", "pit.csv", "--radar", "ku-12-18", "--range-lines", 64)
    echogram = xr.load_dataset(tmp_path / "pit.nc")
    assert echogram.sizes["slow_time"] == 64
    assert (echogram["Data"] > 0).all()
    assert "64 range lines" in run("info", "pit.nc")


def test_one_trains_on_scenes_and_tracks_with_the_network(snowsim, tmp_path):
    write_frames(tmp_path)
    run = snowsim("[track]")
    # The CPU build of torch first, as README says; then what else `learn` needs.
    version, index = (
        re.search(rf"^{name} \S*= (\S+)", (ROOT / "Makefile").read_text(), re.MULTILINE)[1]
        for name in ("TORCH_VERSION", "TORCH_INDEX")
    )
    run_in(tmp_path, "bare/bin/python", ROOT / "envs/install_torch.py", version, index)
    run_in(tmp_path, "bare/bin/python", "-m", "pip", "install", "-q", "onnx", "safetensors")
    run("scenes", "drawn", "-n", 30, "--range-bins", 400)
    run("train", "drawn", "-o", "mine.onnx", "--from", "universal", "--steps", 20)
    run("track", "test_e.nc", "-o", "picked", "--model", "mine.onnx")
    assert (tmp_path / "picked/test_e_layers.nc").is_file()


@pytest.mark.parametrize("n_frames", [1, 6])
def test_one_fits_their_own_flight_and_is_told_what_it_is_too_short_for(
    snowsim, tmp_path, n_frames
):
    settings = checked_settings({"radar": {"n_range_bins": 800}})
    climate = draw_climate(settings, rng=np.random.default_rng(1))
    rows = ["frame\techogram\tlayers\trole"]
    for number in range(n_frames):
        rng = np.random.default_rng(number)
        at = {"climate": climate, "settings": settings, "rng": rng}
        echogram, layers = draw_frame(number + 2, 12, 900, **at)
        write_dataset(tmp_path / f"{number}_e.nc", echogram)
        write_dataset(tmp_path / f"{number}_l.nc", layers)
        rows.append(f"f{number}\t{number}_e.nc\t{number}_l.nc\tstatistics")
    (tmp_path / "frames.tsv").write_text("\n".join(rows))
    (tmp_path / "own.py").write_text(OWN)
    snowsim()
    told, outcome = run_in(tmp_path, "bare/bin/python", "-I", "own.py").splitlines()
    assert int(told) > 0
    refused = outcome.startswith(("refused labels:", "refused zones need"))
    assert outcome.startswith("drawn") or refused
    if n_frames == 6:
        assert outcome.startswith("drawn")
