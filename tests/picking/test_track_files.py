"""Files tracked: whatever holds an echogram, and what is written of it."""

import formats
import numpy as np
import pytest
import scipy.io
from numpy.testing import assert_allclose, assert_array_equal
from planted_layers import BIN_S, SEGMENT, WRITERS, content_of, planted

from snowsim.cli import main
from snowsim.io import read_layers
from snowsim.io.describe import describe
from snowsim.io.images import write_image
from snowsim.picking import canonical
from snowsim.tracking import track_files


@pytest.fixture
def lines():
    """What a run says."""
    return []


@pytest.fixture
def track(weights, tmp_path, lines):
    def run(paths, **options):
        options = {"model": str(weights), "say": lines.append} | options
        return track_files(paths, tmp_path / "out", **options)

    return run


@pytest.mark.parametrize("kind", WRITERS)
def test_layers_of_every_format_are_read_back_with_the_same_travel_times(
    kind, track, tmp_path, frame
):
    echogram, planted_layers = frame
    name, write = WRITERS[kind]
    content = content_of(echogram)
    write(tmp_path / name, content)
    assert track([tmp_path / name]) == 0
    netcdf = read_layers(tmp_path / "out" / f"{(tmp_path / name).stem}_layers.nc")
    assert netcdf["layer"].values.tolist() == ["surface", *(f"snow_{n}" for n in range(1, 5))]
    error = netcdf["twtt"].values - 3e-6 - planted_layers["twtt"].values
    assert np.nanmax(np.abs(error)) < BIN_S
    assert {"confidence", "twtt_low", "twtt_high"} <= set(netcdf)
    layer_file = tmp_path / "out" / "CSARP_layer" / SEGMENT / f"Data_{SEGMENT}_001.mat"
    back = read_layers(layer_file)
    assert_array_equal(back["twtt"], netcdf["twtt"])
    assert_array_equal(back["layer"], netcdf["layer"])
    assert_array_equal(back["quality"], netcdf["quality"])
    assert "snow_4: " in " ".join(map(str, describe(layer_file).values()))
    stored = scipy.io.loadmat(layer_file)
    if kind.startswith("mat"):
        assert_array_equal(stored["gps_time"][0], content["GPS_time"])
    else:
        assert_allclose(stored["gps_time"][0], content["GPS_time"], rtol=0, atol=3e-7)


def test_frames_of_a_segment_that_follow_one_another_keep_their_layers(track, tmp_path, rng):
    echogram, layers = planted(rng, n_lines=500)
    parts = [slice(0, 260), slice(260, 500)]
    paths = [tmp_path / f"Data_{SEGMENT}_{number:03d}.mat" for number in (7, 8)]
    for path, part in zip(paths, parts, strict=True):
        formats.write_mat5(path, content_of(echogram, part))
    assert track(paths[::-1]) == 0
    folder = tmp_path / "out" / "CSARP_layer" / SEGMENT
    for path, part in zip(paths, parts, strict=True):
        found = read_layers(folder / path.name)
        assert found["layer"].values.tolist() == ["surface", *(f"snow_{n}" for n in range(1, 5))]
        error = found["twtt"].values - 3e-6 - layers["twtt"].values[:, part]
        assert np.nanmax(np.abs(error)) < BIN_S
        assert np.isfinite(error).mean() > 0.97


def test_frames_that_do_not_follow_one_another_share_no_layer_but_the_surface(
    track, tmp_path, frame
):
    paths = [tmp_path / f"Data_{SEGMENT}_{number:03d}.mat" for number in (1, 3)]
    for path in paths:
        formats.write_mat5(path, content_of(frame[0]))
    assert track(paths) == 0
    folder = tmp_path / "out" / "CSARP_layer" / SEGMENT
    one, three = (set(read_layers(folder / path.name)["layer"].values) for path in paths)
    assert one & three == {"surface"}
    assert len(one) == len(three) == 5


def test_a_bad_file_is_one_line_and_the_others_go_on(track, tmp_path, frame, lines):
    good = tmp_path / f"Data_{SEGMENT}_001.mat"
    formats.write_mat5(good, content_of(frame[0]))
    empty = tmp_path / f"Data_{SEGMENT}_002.mat"
    formats.write_mat5(empty, content_of(frame[0]) | {"Data": np.ones((400, 300))})
    text = tmp_path / "notes.txt"
    text.write_text("nothing")
    assert track([text, empty, good, tmp_path / "none.mat"]) == 3
    errors = [line for line in lines if line.startswith("error: ")]
    assert len(errors) == 3
    assert f"{empty}: echogram without contrast" in errors[1]
    assert all("\n" not in line for line in lines)
    assert (tmp_path / "out" / f"{good.stem}_layers.nc").is_file()


def test_files_that_are_there_stay_unless_by_force(track, tmp_path, frame, lines):
    path = tmp_path / f"Data_{SEGMENT}_001.mat"
    formats.write_mat5(path, content_of(frame[0]))
    assert track([path]) == 0
    written = {p: p.read_bytes() for p in (tmp_path / "out").rglob("*") if p.is_file()}
    assert len(written) == 3
    assert track([path]) == 1
    assert "expected none to be there, or force, found one" in lines[-1]
    assert track([path], force=True) == 0
    # The same to the byte: NetCDF holds no date, nor do layer files.
    assert {p: p.read_bytes() for p in written} == written


def test_two_files_of_one_frame_are_refused(track, tmp_path, frame, lines):
    paths = [tmp_path / f"IRSNO1B_{SEGMENT}_001{kind}.nc" for kind in ("", "_deconv")]
    for path in paths:
        formats.write_nsidc(path, content_of(frame[0]))
    assert track(paths) == 1
    assert f"frame: expected one file of each, found that of {paths[0]}" in " ".join(lines)


def test_an_image_gives_rows_and_needs_its_range_bin(track, tmp_path, frame, tracker, lines):
    echogram, layers = frame
    seen = canonical(echogram, tracker.card)
    path = tmp_path / "data_scene.png"
    write_image(path, seen.image(0, 300))
    assert track([path]) == 1
    assert "expected --bin-s, the range bin of an image in seconds, found none" in lines[-1]
    assert track([path], bin_s=BIN_S, png=True) == 0
    found = read_layers(tmp_path / "out" / "data_scene_layers.nc")
    rows = seen.grid.row(layers["twtt"].values[0])  # of the surface, on the image's lines
    assert_allclose(found["row"].values[0], np.diagonal(rows), atol=1.0)
    assert_allclose(found["row"], found["twtt"] / BIN_S, rtol=1e-12)
    assert not (tmp_path / "out" / "CSARP_layer").exists()


def test_picks_are_drawn_on_the_echogram(track, tmp_path, frame):
    from PIL import Image

    path = tmp_path / f"Data_{SEGMENT}_001.mat"
    formats.write_mat5(path, content_of(frame[0]))
    track([path], png=True)
    picture = np.array(Image.open(tmp_path / "out" / f"{path.stem}_picks.png")).astype(int)
    assert picture.shape == (400, 300, 3)
    coloured = np.ptp(picture, axis=2) > 0
    bins = np.rint(frame[1]["twtt"].values / BIN_S).astype(int)
    near = np.zeros(coloured.shape, bool)
    for step in (-1, 0, 1):
        near[bins + step, np.arange(300)] = True
    assert not (coloured & ~near).any()
    assert coloured.sum() > 0.97 * bins.size


def test_the_command_tracks_and_tells_by_its_exit_code(weights, tmp_path, frame, capsys):
    path = tmp_path / "frame.nc"
    formats.opr_dataset(content_of(frame[0])).to_netcdf(path)
    arguments = ["track", str(path), "-o", str(tmp_path / "out"), "--model", str(weights)]
    main(arguments)
    said = capsys.readouterr()
    assert f"{tmp_path / 'out' / 'frame_layers.nc'}: 4 layers below the surface" in said.out
    # Without a segment in its name, the day is one.
    assert (tmp_path / "out/CSARP_layer/20120330_01/Data_20120330_01_001.mat").is_file()
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    assert stopped.value.code == 1
    assert "error: " in capsys.readouterr().err
