"""Every command ends bad input in one line and an exit code; good input is described or written."""

import dataclasses
import resource
import subprocess
import sys
from pathlib import Path

import formats
import netCDF4
import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner
from numpy.testing import assert_allclose
from toy_scenes import toy_scenes

from snowsim import Climate, simulate
from snowsim.cli import commands, main
from snowsim.front import REFERENCE
from snowsim.io import (
    PairSet,
    export_pairs,
    read_layers,
    read_tracker,
    write_image,
    write_scenes,
)
from snowsim.snowpack import PRESETS

RAMP = np.tile(np.linspace(0, 1, 50)[:, None], 20)
TRUTH = np.zeros((50, 20), dtype=bool)
TRUTH[[10, 30]] = True


@pytest.fixture
def place(tmp_path, rng, monkeypatch):
    """Folder to work in, with an image's map, its truth, a scene set, and faulty files."""
    monkeypatch.chdir(tmp_path)
    Path("empty").mkdir()
    write_image("made/data_a.png", (255 * TRUTH).astype(np.uint8))
    write_image("true/layer_binary_a.png", TRUTH)
    arrays = {
        "nan": np.where(TRUTH, np.nan, 0),
        "none": 0 * TRUTH,
        "dark": 1.0 - TRUTH,
        "crossing": np.array([[9.0], [3.0]]) + np.zeros(20),
        "one": TRUTH.astype(float),
        "true": TRUTH,
        "narrow": RAMP[:2, :9],
    }
    for name, values in arrays.items():
        np.save(f"{name}.npy", values)
    write_image("dim.png", TRUTH.astype(np.uint8))
    write_scenes("scenes.nc", toy_scenes(2))
    for cut, whole in (("cut.npy", "one.npy"), ("cut.nc", "scenes.nc")):
        Path(cut).write_bytes(Path(whole).read_bytes()[:-1000])
    Path("text.nc").write_text("no dataset")
    Path("b_layers.nc").touch()
    lines = {name: ("range_line", RAMP[0]) for name in ("layer_bins", "mask")}
    xr.Dataset(lines).to_netcdf("scene_a.nc")
    formats.opr_dataset(formats.truth(rng)).to_netcdf("echogram.nc")
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "code", "printed"),
    [
        ("score", 2, "Missing argument 'PREDICTIONS'"),
        ("score made one.npy", 1, "one.npy: path: expected a folder of files whose names differ"),
        ("score one.npy none.npy", 1, "none.npy: truth: expected at least one layer"),
        ("score one.npy narrow.npy", 1, "one.npy: size: expected (50, 9) as narrow.npy has"),
        ("score nan.npy true.npy", 1, "nan.npy: map: expected numbers in [0, 1], found nan"),
        ("score dim.png true.npy", 1, "dim.png: map: expected 8-bit numbers up to 255"),
        ("score dark.npy true.npy", 1, "dark.npy: expected bright layers on a dark ground"),
        ("score cut.npy true.npy", 1, "cut.npy: NPY: expected a whole array of numbers"),
        ("score scenes.nc true.npy", 1, "scenes.nc: format: expected .png or .npy, found .nc"),
        ("score --picks crossing.npy true.npy", 1, "crossing.npy: layers must increase strictly"),
        (
            "score --picks narrow.npy true.npy",
            1,
            "narrow.npy: size: expected 20 range lines of an image as true.npy has",
        ),
        ("score empty true", 1, "empty: pairs: expected files .png, .npy, each with"),
        ("info text.nc", 1, "text.nc: content: expected"),
        ("info scene_a.nc", 1, "found one scene (xarray opens it; export its scene set)"),
        ("info empty", 1, "empty: scenes: expected files data_*.png"),
        ("export scenes.nc true", 1, "true: folder: expected an empty or a new one, or --force"),
        ("scenes made -n 1", 1, "made: folder: expected an empty or a new one, or --force"),
        (
            "export echogram.nc out",
            2,
            "Open Polar Radar echogram: name the file of its layers, --l",
        ),
        ("export cut.nc out", 1, "cut.nc: "),
        (f"export {REFERENCE} out", 1, "expected a scene file, of attribute format"),
        ("export scenes.nc made out --layers one.npy", 2, "--layers are of one echogram, got 2"),
        ("scenes out --statistics cut.nc", 1, "cut.nc: expected a NetCDF-4 file"),
        ("scenes out --statistics scenes.nc", 1, "content must be 'snowsim flight statistics"),
        ("scenes out -n 1 --looks nan", 1, "n_looks must be finite"),
        ("train scenes.nc -o a.pt", 2, "a.pt: end the name of the file in .onnx"),
        ("scenes out --range-lines 3000000", 2, "2<=x<=65536"),
        ("simulate text.nc/a.nc", 2, "text.nc/a.nc: there is no folder text.nc"),
        ("simulate b.nc", 2, "b_layers.nc: the file is there, --force writes over it"),
        (
            "simulate a.nc --range-lines 3000000",
            1,
            "1 GiB, as readers take, got 3000000: simulate parts",
        ),
        ("simulate a.nc --set height_m nan", 1, "radar: height_m must be finite, above 0"),
        ("simulate a.nc --set bandwidth_hz 1e9", 1, "bin_s must be longer, such as 7.2e-10 s"),
        ("simulate a.nc --set bandwidth_hz 4GHz", 2, "--set bandwidth_hz: expected a number, such"),
    ],
)
def test_bad_input_ends_in_one_line(place, capsys, arguments, code, printed):
    with pytest.raises(SystemExit) as end:
        main(arguments.split())
    assert end.value.code == code
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert printed in err


WRITING = [
    "export frames out",
    "simulate out/a.nc --range-lines 9",
    "scenes out -n 1 --range-lines 64",
]


@pytest.mark.parametrize("arguments", ["score made true", "info made/data_a.png", *WRITING])
def test_no_room_ends_in_one_line(place, rng, arguments):
    write_image(place / "frames/data_a.png", rng.integers(0, 256, size=(50, 20), dtype=np.uint8))
    write_image(place / "frames/layer_binary_a.png", TRUTH)
    (place / "out").mkdir()
    command = [sys.executable, "-c", "from snowsim.cli import main; main()", *arguments.split()]
    # Standard output is a full disk; and no file may grow beyond 500 bytes.
    with open("/dev/full", "w") as full:
        limit = (
            (lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (500, 500)))
            if arguments in WRITING
            else None
        )
        done = subprocess.run(
            command, stdout=full, stderr=subprocess.PIPE, text=True, check=False, preexec_fn=limit
        )
    assert done.returncode == 1
    assert done.stderr.startswith("error: ")
    assert done.stderr.count("\n") == 1
    assert not list(place.glob("out/*"))


TOLD = {
    "nsidc.nc": [
        "format  an IRSNO1B echogram\n",
        "range bins of 2.886e-10 s",
        "slow_time 40",
        "radar   season_name 2012_Greenland_P3",
        "time    2012-03-30T00:00:00 to 2012-03-30T00:00:01 UTC\n",
        "place   70.00000, -40.00000 to 70.00039, -39.99961 (degrees",
    ],
    "silent.nc": ["note    not tracked: silent.nc: range lines with 30 range bins or more"],
    "frame.nc": [
        "radar   radar_name simulated",
        "note    no positions: range lines are used as they are\n",
    ],
    "layers.mat": ["format  CReSIS layers\n", "layers  id 1\n", "place   70.0"],
    "scenes.nc": ["a set of scenes\n", "3 scenes of 96 range bins, 64 range lines, 3 to 4 layers"],
    "set": ["format  a folder of benchmark pairs\n", "2 scenes of 96 range bins"],
    "mask.png": ["format  a PNG image\n", "range_bin 50, range_line 20"],
    "shades.npy": ["range_bin 50, range_line 20"],
    REFERENCE: ["format  statistics of a flight\n", "layer 57"],
}


def described(path, capsys):
    main(["info", str(path)])
    return capsys.readouterr().out


def test_info_says_what_a_file_is_and_what_tracking_would_note(tmp_path, rng, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    content = formats.truth(rng)
    formats.write_nsidc("nsidc.nc", content)
    frame, _ = simulate(Climate(accumulation_m=0.3), "snow-2012", n_range_lines=300, rng=1)
    frame["Latitude"][:] = np.nan
    frame.to_netcdf("frame.nc")
    frame.assign(Data=frame["Data"] * np.nan).to_netcdf("silent.nc")
    layers = formats.layer_content([content["Surface"]], [1], content["GPS_time"])
    formats.write_mat5("layers.mat", layers)
    scenes = [dataclasses.replace(scene, name=f"toy_{i}") for i, scene in enumerate(toy_scenes(2))]
    fewer = dataclasses.replace(scenes[0], name="fewer", layer_bins=scenes[0].layer_bins[:3])
    write_scenes("scenes.nc", [fewer, *scenes])
    export_pairs(tmp_path / "set", scenes)
    write_image(tmp_path / "mask.png", TRUTH)
    np.save("shades.npy", RAMP)
    for name, parts in TOLD.items():
        printed = described(name, capsys)
        for part in parts:
            assert part in printed, name


def test_own_frames_and_scenes_are_exported_with_a_line_of_what_reading_warns_of(
    tmp_path, rng, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    formats.write_nsidc_flight(tmp_path, rng, ["test"], 300)
    with netCDF4.Dataset("test.nc", "r+") as file:
        file["Surface"][:] -= 30 * formats.BIN_S
    main(["export", "test.nc", "--layers", formats.LAYERS_FILE, "pairs"])
    main(["export", "pairs", "again"])
    out, err = capsys.readouterr()
    assert out.splitlines() == 2 * ["n_scenes 1, n_merged_pixels 0"]
    (line,) = err.splitlines()
    assert line.startswith(f"warning: {formats.LAYERS_FILE}: layer 0 lies 30 range bins")
    (scene,) = PairSet("pairs")
    assert np.isfinite(scene.layer_bins).all()
    export_pairs("others", [dataclasses.replace(scene, name="other")])
    main(["export", "pairs", "others", "--force"])
    assert "others: scenes that were there before stay (1)" in capsys.readouterr().err
    # What was exported is truth: of itself, without an error.
    main(["score", "--picks", "pairs", "pairs", "--format", "csv"])
    assert "test_000,0,0,1,1,2,0,0" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["Data_20130417_02_005.mat", "mine.nc"])
def test_labels_exported_of_a_simulation_lie_on_its_echoes(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    main(["simulate", name, "--range-lines", "256", "--accumulation-m", ".5", "--years", "6"])
    (layers_file,) = Path().glob("CSARP_layer/Data*" if name[0] == "D" else "mine_layers.nc")
    main(["export", name, "--layers", str(layers_file), "pairs"])
    (scene,) = PairSet("pairs")
    layers = read_layers(layers_file) / PRESETS["snow-2-8"].bin_s
    # The surface of the crop, row 50, is the interface; labels lie in whole bins, so that each is
    # off by half a bin at most.
    lag_bins = (layers["peak_twtt"] - layers["twtt"])[0].median()
    assert lag_bins > 3
    assert_allclose(np.median(scene.layer_bins[0]), 50 + lag_bins, atol=1.01)
    peaks = layers["peak_twtt"].values[:, 0]
    assert_allclose(np.diff(scene.layer_bins[:, 0]), np.diff(peaks), atol=1.01)


def test_help_has_examples_of_every_command():
    for name in commands.list_commands(None):
        printed = CliRunner().invoke(commands, [name, "--help"]).output
        assert f"\n    snowsim {name} " in printed


def test_a_tracker_is_trained_on_scenes_of_several_files_from_the_shipped_one(place, capsys):
    write_scenes("more.nc", toy_scenes(5)[2:])
    main(
        ["train", "scenes.nc", "more.nc", "-o", "mine.onnx", "--from", "universal", "--steps", "2"]
    )
    assert "mine.onnx: scenes held out: 1, too few for a score" in capsys.readouterr().out
    content, card = read_tracker("mine.onnx")
    assert "4 scenes" in card["trained_on"]  # of 5 the first is held out
    assert "starting from universal" in card["trained_on"]
    Path("mine.onnx").unlink()
    with pytest.raises(SystemExit):
        main(["train", "scenes.nc", "-o", "mine.onnx"])
    assert "mine.json: the file is there, --force writes over it" in capsys.readouterr().err


def test_train_without_torch_says_in_a_line_what_to_install(place, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "torch", None)
    users = tuple(f"snowsim.{name}" for name in ("learning", "patches", "tracker", "training"))
    for name in [name for name in sys.modules if name.startswith(users)]:
        monkeypatch.delitem(sys.modules, name)
    with pytest.raises(SystemExit):
        main(["train", "scenes.nc", "-o", "mine.onnx"])
    assert capsys.readouterr().err == "error: train needs torch: pip install 'snowsim[learn]'\n"


@pytest.mark.parametrize(("closed", "file", "code"), [(">&-", "true.npy", 0), ("2>&-", "none", 2)])
def test_a_command_runs_without_an_output_to_print_to(place, closed, file, code):
    command = f"import sys; from snowsim.cli import main; main(['info', {file!r}])"
    shell = ["bash", "-c", f'"$@" {closed}', "bash", sys.executable, "-c", command]
    ended = subprocess.run(shell, capture_output=True, text=True)
    assert (ended.returncode, ended.stderr) == (code, "")
