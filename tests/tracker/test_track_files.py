"""Files tracked: whatever holds an echogram, and what is written of it."""

import os
import signal
import time

import formats
import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from planted_layers import BIN_S, NAMES, SEGMENT, WRITERS, content_of, planted, write_weights
from refusals import refusal

from snowsim.cli import main
from snowsim.io import open_segment, read_layers, write_image
from snowsim.io.describe import describe
from snowsim.io.files import read_arrays, write_arrays
from snowsim.tracker import canonical
from snowsim.tracking import Tracker, track_files
from snowsim.tracking.unfinished import from_arrays, to_arrays


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


@pytest.fixture
def dataset(frame):
    """The planted echogram as Open Polar Radar has it."""
    return formats.opr_dataset(content_of(frame[0]))


def write_frame(folder, echogram, number=1, lines=slice(None), **changes):
    """Path of a file of some range lines: a frame of `SEGMENT`."""
    path = folder / f"Data_{SEGMENT}_{number:03d}.mat"
    formats.write_mat5(path, content_of(echogram, lines) | changes)
    return path


@pytest.mark.parametrize("kind", WRITERS)
def test_layers_of_every_format_are_read_back_with_the_same_travel_times(
    kind, track, tmp_path, frame
):
    echogram, planted_layers = frame
    name, write = WRITERS[kind]
    write(tmp_path / name, content_of(echogram))
    assert track([tmp_path / name]) == 0
    netcdf = read_layers(tmp_path / "out" / f"{SEGMENT}_layers.nc")
    assert set(netcdf["frame"].values) == {(tmp_path / name).stem}
    assert netcdf["layer"].values.tolist() == NAMES
    error = netcdf["twtt"].values - 3e-6 - planted_layers["twtt"].values
    assert np.nanmax(np.abs(error)) < BIN_S
    layer_file = tmp_path / "out" / "CSARP_layer" / SEGMENT / f"Data_{SEGMENT}_001.mat"
    back = read_layers(layer_file)
    assert_array_equal(back["twtt"], netcdf["twtt"])
    assert_array_equal(back["layer"], netcdf["layer"])
    formats.check_times(back, content_of(echogram)["GPS_time"])
    assert describe(layer_file)[0]["layers"] == ", ".join(NAMES)


def test_frames_of_a_segment_that_follow_one_another_keep_their_layers(track, tmp_path, rng):
    echogram, layers = planted(rng, n_lines=500)
    parts = [slice(0, 260), slice(260, 500)]
    paths = [write_frame(tmp_path, echogram, 7 + n, part) for n, part in enumerate(parts)]
    assert track(paths[::-1]) == 0
    folder = tmp_path / "out" / "CSARP_layer" / SEGMENT
    for path, part in zip(paths, parts, strict=True):
        found = read_layers(folder / path.name)
        assert found["layer"].values.tolist() == NAMES
        error = found["twtt"].values - 3e-6 - layers["twtt"].values[:, part]
        assert np.nanmax(np.abs(error)) < BIN_S
        assert np.isfinite(error).mean() > 0.97
    (written,) = (tmp_path / "out").glob("*.nc")
    whole = open_segment(written)
    assert_array_equal(whole["layer"], NAMES)
    assert_array_equal(whole["frame"], 260 * [paths[0].stem] + 240 * [paths[1].stem])
    joined = open_segment([folder / path.name for path in paths[::-1]])
    for name in ("twtt", "quality", "slow_time", "Latitude", "frame"):
        assert_array_equal(joined[name], whole[name])
    for wrong, message in (
        ([], "files: expected those of its"),
        ([written, written], "frames that follow one another, found frames overlap in time"),
    ):
        with refusal(message):
            open_segment(wrong)


def test_a_bad_file_is_one_line_and_the_others_go_on(track, tmp_path, frame, lines):
    good = write_frame(tmp_path, frame[0])
    empty = write_frame(tmp_path, frame[0], 2, Data=np.ones((400, 300)))
    text = tmp_path / "notes.txt"
    text.write_text("nothing")
    assert track([text, empty, good, tmp_path / "none.mat"]) == 3
    errors = [line for line in lines if line.startswith("error: ")]
    assert len(errors) == 3
    assert f"{empty}: contrast [dB] must be finite, at least 0.001" in errors[2]
    assert all("\n" not in line for line in lines)
    assert read_layers(tmp_path / "out" / f"{SEGMENT}_layers.nc").sizes["slow_time"] == 300


def test_a_bad_frame_leaves_its_segment_in_two_parts(track, tmp_path, rng, lines):
    echogram, _ = planted(rng, n_lines=600)
    parts = [slice(200 * n, 200 * n + 200) for n in range(3)]
    paths = [write_frame(tmp_path, echogram, 1 + n, part) for n, part in enumerate(parts)]
    paths[1].write_bytes(paths[1].read_bytes()[:20_000])
    assert track(paths) == 1
    (error,) = [line for line in lines if line.startswith("error: ")]
    assert str(paths[1]) in error
    folder = tmp_path / "out" / "CSARP_layer" / SEGMENT
    assert not (folder / paths[1].name).exists()
    first, last = (read_layers(folder / paths[n].name)["layer"].values for n in (0, 2))
    assert first.tolist() == NAMES
    # Nobody knows which layer is which beyond the gap.
    assert last.tolist() == ["surface", *(f"snow_{n}" for n in range(5, 9))]


def test_an_interrupt_leaves_the_segments_that_were_finished(
    track, tmp_path, frame, lines, monkeypatch
):
    first = write_frame(tmp_path, frame[0])
    second = tmp_path / "Data_20120401_02_001.mat"
    formats.write_mat5(second, content_of(frame[0]))
    detect = Tracker.detect

    def interrupted(tracker, echogram, where):
        if where == str(second):
            raise KeyboardInterrupt
        return detect(tracker, echogram, where)

    monkeypatch.setattr(Tracker, "detect", interrupted)
    with pytest.raises(KeyboardInterrupt):
        track([first, second])
    assert (tmp_path / f"out/{SEGMENT}_layers.nc").is_file()
    assert (tmp_path / f"out/CSARP_layer/{SEGMENT}/layer_{SEGMENT}.mat").is_file()
    assert not list((tmp_path / "out").rglob("*20120401_02*"))


class Bar:
    """What `track_files` needs of a bar of tqdm."""

    def __init__(self):
        self.n = 0
        self.texts = []

    def update(self, n):
        self.n += n

    def set_postfix_str(self, text, refresh):
        self.texts.append(text)

    def close(self):
        self.is_closed = True


@pytest.fixture
def two_segments(tmp_path, rng):
    """Files of two segments: three frames of the first, the second of them bad, and one frame."""
    echogram, _ = planted(rng, n_lines=600)
    parts = [slice(200 * n, 200 * n + 200) for n in range(3)]
    paths = [write_frame(tmp_path, echogram, 1 + n, part) for n, part in enumerate(parts)]
    paths[1].write_text("bad")
    paths.append(tmp_path / "Data_20120401_02_001.mat")
    formats.write_mat5(paths[-1], content_of(echogram, parts[0]))
    return paths


def contents(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def times(folder):
    return {path: path.stat().st_mtime_ns for path in folder.rglob("*") if path.is_file()}


def test_what_is_whole_is_left_on_resuming_and_its_bad_frames_are_named_again(
    track, tmp_path, two_segments, lines
):
    out = tmp_path / "out"
    assert track(two_segments) == 1
    before = contents(out)
    (error,) = [line for line in lines if line.startswith("error: ")]
    missing = [
        out / "20120401_02_layers.nc",
        out / f"CSARP_layer/{SEGMENT}/layer_{SEGMENT}.mat",
        out / f"CSARP_layer/{SEGMENT}/Data_{SEGMENT}_003.mat",
        out / f"{SEGMENT}_layers.nc",
    ]
    for path in (None, *missing):
        whole = times(out)
        if path is not None:
            path.unlink()
        lines.clear()
        assert track(two_segments, resume=True) == 1
        assert lines.count(error) == 1
        assert sum("it was written before" in line for line in lines) == 2 - (path is not None)
        assert contents(out) == before
        name = "20120401_02" if path is None or SEGMENT in str(path) else SEGMENT
        left = [each for each in whole if name in str(each)]
        assert all(times(out)[each] == whole[each] for each in left)
    damaged = out / f"{SEGMENT}_layers.nc"
    damaged.write_bytes(before[damaged][:500])
    assert track(two_segments, resume=True) == 1
    assert contents(out) == before


@pytest.mark.parametrize("change", ["other frame", "repaired", "other tracker"])
def test_layers_of_other_inputs_or_another_tracker_are_refused_on_resuming(
    track, tmp_path, two_segments, lines, frame, change, weights
):
    assert track(two_segments) == 1
    before = contents(tmp_path / "out")
    options = {}
    if change == "other tracker":
        other = tmp_path / "other"
        other.mkdir()
        options["model"] = str(write_weights(other, weights.read_bytes(), threshold=0.6))
    else:
        write_frame(tmp_path, frame[0], 3 if change == "other frame" else 2)
    lines.clear()
    assert track(two_segments, resume=True, **options) == (3 if not options else 4)
    assert "tracked_together: expected" in lines[0]
    assert "or --force (force=True), found" in lines[0]
    assert contents(tmp_path / "out") == before
    assert track(two_segments, resume=True, force=True, **options) == (change != "repaired")
    assert contents(tmp_path / "out") != before


def test_without_resume_what_is_there_is_refused(track, two_segments, lines):
    assert track(two_segments) == 1
    lines.clear()
    assert track(two_segments) == 4
    assert all("--force (force=True) to write over it" in line for line in lines)


def test_missing_pictures_of_a_whole_segment_are_drawn_on_resuming(track, tmp_path, frame):
    path = write_frame(tmp_path, frame[0])
    track([path])
    layers = times(tmp_path / "out")
    assert track([path], png=True, resume=True) == 0
    picture = tmp_path / f"out/{path.stem}_picks.png"
    drawn = picture.read_bytes()
    picture.unlink()
    assert track([path], png=True, resume=True) == 0
    assert picture.read_bytes() == drawn
    assert layers.items() <= times(tmp_path / "out").items()


def test_of_a_long_segment_an_interrupt_loses_no_frame_that_was_seen(
    track, tmp_path, rng, monkeypatch
):
    monkeypatch.setattr("snowsim.tracking.segments.MOST_LOST", 2)
    echogram, _ = planted(rng, n_lines=600)
    paths = [
        write_frame(tmp_path, echogram, 1 + n, slice(150 * n, 150 * n + 150)) for n in range(4)
    ]
    assert track(paths) == 0
    out = tmp_path / "out"
    before = contents(out)
    assert not (out / ".unfinished").exists()
    for path in before:
        path.unlink()
    seen = []
    detect = Tracker.detect

    def detected(tracker, echogram, where):
        if len(seen) == 3:
            seen.append("interrupt")
            raise KeyboardInterrupt
        seen.append(where)
        return detect(tracker, echogram, where)

    monkeypatch.setattr(Tracker, "detect", detected)
    with pytest.raises(KeyboardInterrupt):
        track(paths)
    kept = sorted((out / ".unfinished").iterdir())
    assert len(kept) == 3
    assert set(contents(out)) == set(kept)
    kept[0].write_bytes(kept[0].read_bytes()[:-100])  # a damaged one counts for nothing
    assert track(paths, resume=True) == 0
    assert len(seen) == 6
    assert contents(out) == before
    assert not (out / ".unfinished").exists()


def test_one_and_two_processes_write_the_same_bytes(track, tmp_path, two_segments, lines):
    assert track(two_segments) == 1
    out = tmp_path / "out"
    one = contents(out)
    said = sorted(lines)
    lines.clear()
    for path in one:
        path.unlink()
    bar = Bar()
    assert track(two_segments, processes=2, progress=lambda total: bar) == 1
    assert contents(out) == one
    assert sorted(lines) == said
    assert (bar.n, bar.is_closed) == (4, True)
    assert track(two_segments, processes=2, resume=True) == 1


def test_a_process_that_is_killed_is_one_line_and_what_was_written_stays(
    track, tmp_path, two_segments, monkeypatch
):
    detect = Tracker.detect

    def killed(tracker, echogram, where):
        if "20120401_02" in where:
            time.sleep(3)  # until the other segment is written
            os.kill(os.getpid(), signal.SIGKILL)
        return detect(tracker, echogram, where)

    monkeypatch.setattr(Tracker, "detect", killed)
    with pytest.raises(ChildProcessError, match="a process was killed: is there memory"):
        track(two_segments, processes=2)
    out = tmp_path / "out"
    assert not (out / "20120401_02_layers.nc").exists()
    monkeypatch.undo()
    assert track(two_segments, processes=2, resume=True) == 1
    assert (out / "20120401_02_layers.nc").exists()
    assert (out / f"{SEGMENT}_layers.nc").exists()


def test_evidence_that_was_kept_gives_the_same_layers(tracker, tmp_path, frame):
    echogram = frame[0].assign_attrs(day_seg=SEGMENT)
    mask = (np.arange(300) // 200).astype(np.uint8)
    flags = {"flag_masks": np.array([1, 2], np.uint8), "flag_meanings": "no_good_data low_SNR"}
    echogram["quality_mask"] = ("slow_time", mask, flags)
    evidence = tracker.detect(echogram).with_notes(["a note"])
    write_arrays(tmp_path / "kept.npz", to_arrays(evidence))
    kept = from_arrays(read_arrays(tmp_path / "kept.npz"))
    expected, found = (tracker.pick_together([each])[0] for each in (evidence, kept))
    assert "a note" in found.attrs["notes"]
    is_bad = (found["quality"] == 3).where(found["twtt"].notnull())
    assert is_bad[:, 200:].mean() == 1
    assert is_bad[:, :200].mean() < 0.5
    xr.testing.assert_identical(found, expected)


def test_the_bar_counts_files_and_is_told_range_lines(track, tmp_path, frame):
    bars = []

    def bar(total):
        bars.append(Bar())
        assert total == 2
        return bars[0]

    (tmp_path / f"Data_{SEGMENT}_002.mat").write_text("bad")
    paths = [write_frame(tmp_path, frame[0]), tmp_path / f"Data_{SEGMENT}_002.mat"]
    track([*paths, tmp_path / "none.mat"], progress=bar)
    assert (bars[0].n, bars[0].is_closed) == (2, True)
    assert all(text.endswith("range lines/s") for text in bars[0].texts)


def test_files_that_are_there_stay_unless_by_force(track, tmp_path, frame, lines):
    path = write_frame(tmp_path, frame[0])
    assert track([path]) == 0
    written = {p: p.read_bytes() for p in (tmp_path / "out").rglob("*") if p.is_file()}
    assert track([path]) == 1
    assert "expected none, or --force (force=True) to write over it, found one" in lines[-1]
    assert track([path], force=True) == 0
    # The same to the byte: NetCDF holds no date, nor do layer files.
    assert {p: p.read_bytes() for p in written} == written


def test_two_files_of_one_frame_are_refused(track, tmp_path, frame, lines):
    paths = [tmp_path / f"IRSNO1B_{SEGMENT}_001{kind}.nc" for kind in ("", "_deconv")]
    for path in paths:
        formats.write_nsidc(path, content_of(frame[0]))
    assert track(paths) == 1
    assert f"frame: expected one file of each, found that of {paths[0]}" in " ".join(lines)


@pytest.mark.parametrize("names", [("a/s.nc", "b/s.nc"), ("s.nc", "s.png")])
def test_two_inputs_of_one_name_are_refused_before_anything_is_tracked(
    track, tmp_path, dataset, names, lines
):
    paths = [tmp_path / name for name in names]
    for path in paths:
        path.parent.mkdir(exist_ok=True)
        dataset.to_netcdf(path)
    with refusal(f"^{paths[1]}: name: .* found {paths[0]} too"):
        track(paths)
    assert not lines


def test_an_image_of_the_name_of_a_segment_is_refused(track, tmp_path, frame):
    write_image(tmp_path / f"{SEGMENT}.png", np.ones((300, 64), np.uint8))
    with refusal("name: expected another than that of a segment"):
        track([write_frame(tmp_path, frame[0]), tmp_path / f"{SEGMENT}.png"])


def test_a_line_of_twenty_layers_takes_less_than_250_bytes(track, tmp_path, rng, lines):
    n_lines = 1000
    echogram, _ = planted(rng, n_lines=n_lines, n_bins=1200)
    power = echogram["Data"].values
    for n in range(16):  # below the four layers that are there
        below = 1 + 200 * np.exp(-0.5 * ((np.arange(1200) - 300 - 40 * n) / 1.3) ** 2)
        swell = np.rint(6 * np.sin(2 * np.pi * np.arange(n_lines) / 150)).astype(int)
        power *= below[(np.arange(1200)[:, None] - swell) % 1200]
    path = write_frame(tmp_path, echogram)
    assert track([path]) == 0
    layers = read_layers(tmp_path / f"out/{SEGMENT}_layers.nc")
    assert layers.sizes["layer"] == 21
    assert layers["twtt"].notnull().mean() > 0.95
    written = [path.stat().st_size for path in (tmp_path / "out").rglob("*") if path.is_file()]
    assert sum(written) < 250 * n_lines


def test_frames_without_number_are_numbered_by_time(track, tmp_path, dataset):
    paths = [tmp_path / "a.nc", tmp_path / "b.nc"]
    for path, lines in zip(paths, (slice(150, 300), slice(0, 150)), strict=True):
        dataset.isel(slow_time=lines).to_netcdf(path)
    assert track(paths) == 0
    folder = tmp_path / "out/CSARP_layer/20120330_01"
    first = read_layers(folder / "Data_20120330_01_001.mat")
    assert first["slow_time"].values[0] == dataset["slow_time"].values[0]


@pytest.mark.parametrize("day_seg", ["../../elsewhere", "/tmp/20120330_04", "20120330_04/x"])
def test_a_segment_that_is_a_path_is_refused(track, tmp_path, dataset, lines, day_seg):
    path = tmp_path / "frame.nc"
    dataset.assign_attrs(day_seg=day_seg).to_netcdf(path)
    assert track([path]) == 1
    assert lines == [
        f"error: {path}: day_seg: expected a segment such as 20120330_04, found {day_seg}"
    ]


@pytest.mark.parametrize(
    "attributes",
    [
        {"granule": "20120330_04_007"},
        {"segment_path": "20120330_04", "frame": 7},
        {"day_seg": "20120330_04", "frame": 7},
    ],
    ids=["granule", "segment_path", "day_seg"],
)
def test_segment_and_frame_are_read_from_what_xopr_writes(track, tmp_path, dataset, attributes):
    path = tmp_path / "saved.nc"
    dataset.assign_attrs(attributes).to_netcdf(path)
    assert track([path]) == 0
    assert (tmp_path / f"out/CSARP_layer/{SEGMENT}/Data_{SEGMENT}_007.mat").is_file()


@pytest.mark.parametrize(
    ("number", "stretched", "later_s", "n_shared", "message"),
    [
        (2, 1, 0.0, 5, ""),
        (2, 40, 0.0, 5, ""),  # 1.7 s from line to line, and 3 lines are missing
        (2, 1, 30.0, 1, "begins 30.2 s after that ends, more than 2 s"),
        (2, 1, -5.0, 1, "begins 4.83 s before that ends"),
        (3, 1, 0.0, 1, "1 frame is missing between them"),
    ],
    ids=["follows", "slow lines", "pause", "overlap", "a frame is missing"],
)
def test_layers_go_on_in_the_next_frame_unless_a_gap_in_time_is_said(
    track, tmp_path, frame, lines, number, stretched, later_s, n_shared, message
):
    parts = {1: (slice(0, 150), 0.0), number: (slice(153, 300), later_s)}
    paths = []
    for which, (part, shift_s) in parts.items():
        since = content_of(frame[0], part)["GPS_time"] - formats.GPS_START
        gps_time = formats.GPS_START + stretched * since + shift_s
        paths.append(write_frame(tmp_path, frame[0], which, part, GPS_time=gps_time))
    assert track(paths) == 0
    said = [line for line in lines if "not linked with frame 1" in line]
    first, second = (
        set(read_layers(tmp_path / f"out/CSARP_layer/{SEGMENT}/{path.name}")["layer"].values)
        for path in paths
    )
    assert len(first) == len(second) == 5
    assert len(first & second) == n_shared
    assert len(said) == bool(message)
    assert message in "".join(said)


def test_range_lines_that_two_frames_have_are_once_in_the_file_of_the_segment(
    track, tmp_path, rng, lines
):
    echogram, _ = planted(rng, n_lines=500)
    parts = {1: slice(0, 260), 2: slice(200, 500), 3: slice(100, 200)}
    paths = [write_frame(tmp_path, echogram, number, part) for number, part in parts.items()]
    assert track(paths) == 0
    whole = open_segment([tmp_path / f"out/{SEGMENT}_layers.nc"])
    formats.check_times(whole, content_of(echogram)["GPS_time"])
    names, counts = np.unique(whole["frame"].values.astype(str), return_counts=True)
    assert dict(zip(names, counts, strict=True)) == {paths[0].stem: 260, paths[1].stem: 240}
    notes = whole.attrs["notes"]
    for name, n in ((paths[1].stem, 60), (paths[2].stem, 100)):
        note = f"{name}: {n} range lines before the end of {paths[0].stem} are left out here"
        assert note in notes
        assert sum(note in line for line in lines) == 1
    folder = tmp_path / "out/CSARP_layer" / SEGMENT
    assert read_layers(folder / paths[2].name).sizes["slow_time"] == 100


def test_a_late_frame_of_a_tracked_segment_is_refused_with_the_remedy(
    track, tmp_path, frame, lines, monkeypatch
):
    paths = [write_frame(tmp_path, frame[0], number) for number in (1, 2)]
    assert track(paths[:1]) == 0
    monkeypatch.setattr("snowsim.tracking.segments._load_and_detect", None)  # it is not tracked
    assert track(paths[1:], force=True) == 1
    assert "track all frames of the segment at once, or to another folder" in lines[-1]
    assert f"found {paths[0].name}" in lines[-1]


def test_frames_that_were_tracked_in_separate_calls_are_refused(weights, tmp_path, frame):
    later = content_of(frame[0])["GPS_time"] + 60
    paths = [
        write_frame(tmp_path, frame[0], 1),
        write_frame(tmp_path, frame[0], 2, GPS_time=later),
    ]
    options = {"model": str(weights), "say": lambda line: None}
    assert track_files(paths, tmp_path / "both", **options) == 0
    for number, path in enumerate(paths):
        assert track_files([path], tmp_path / f"apart_{number}", **options) == 0
    pattern = "CSARP_layer/*/Data_*.mat"
    both = sorted((tmp_path / "both").glob(pattern))
    assert open_segment(both).attrs["tracked_together"]
    apart = [
        tmp_path / f"apart_{number}" / path.relative_to(tmp_path / "both")
        for number, path in enumerate(both)
    ]
    of_segment = [tmp_path / f"apart_{number}/{SEGMENT}_layers.nc" for number in (0, 1)]
    for files in (apart, of_segment):
        with refusal("track them in one call.*found 2 calls of track"):
            open_segment(files)
    whole = xr.load_dataset(tmp_path / f"both/{SEGMENT}_layers.nc")
    frames = []
    for number, path in enumerate(paths):
        frames.append(tmp_path / f"{number}_layers.nc")
        corrected = ["confidence"] if number == 0 else []
        is_frame = whole["frame"] == path.stem
        whole.isel(slow_time=is_frame.values).drop_vars(corrected).to_netcdf(frames[-1])
    with pytest.warns(UserWarning, match="1 of 2 frames have no confidence, as a person's"):
        open_segment(frames)


def test_layers_beside_their_input_stay_also_by_force(track, tmp_path, dataset, lines):
    (tmp_path / "out").mkdir()
    path = tmp_path / "out/frame.nc"
    dataset.to_netcdf(path)
    truth = tmp_path / "out/20120330_01_layers.nc"
    truth.write_text("truth")
    assert track([path], force=True) == 1
    assert f"{truth}: file: expected none beside the input" in lines[-1]
    assert truth.read_text() == "truth"


@pytest.mark.parametrize("name", ["", "file/below"])
def test_a_folder_that_cannot_be_is_refused_before_anything_is_tracked(
    weights, tmp_path, name, lines
):
    (tmp_path / "file").write_text("")
    folder = tmp_path / name if name else name
    with refusal("output: expected a folder"):
        track_files([tmp_path / "none.nc"], folder, model=str(weights), say=lines.append)
    assert not lines


def test_a_picture_of_dark_layers_on_bright_ground_is_said(track, tmp_path, frame, tracker, lines):
    image = canonical(frame[0], tracker.card).image(0, 300)
    write_image(tmp_path / "right.png", image)
    write_image(tmp_path / "inverted.png", 255 - image)
    track([tmp_path / "right.png", tmp_path / "inverted.png"], bin_s=BIN_S)
    (said,) = [line for line in lines if "expected bright layers on a dark ground" in line]
    assert said.startswith(str(tmp_path / "inverted.png"))


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

    path = write_frame(tmp_path, frame[0])
    track([path], png=True)
    picture = np.array(Image.open(tmp_path / "out" / f"{path.stem}_picks.png").convert("RGB"))
    coloured = np.ptp(picture.astype(int), axis=2) > 60
    # Five layers level with the surface; they are some 900 pixels long.
    assert (coloured.sum(axis=1) > 500).sum() >= 5


def test_a_long_frame_is_drawn_in_pieces_of_which_each_has_its_own_lines(
    track, tmp_path, frame, monkeypatch
):
    drawn = []

    def note(path, layers, echograms):
        drawn.append((path.name, layers["slow_time"].values))

    monkeypatch.setattr("snowsim.io.pictures.write_picture", note)
    monkeypatch.setattr("snowsim.io.pictures.LINES_OF_PICTURE", 140)
    path = write_frame(tmp_path, frame[0])
    assert track([path], png=True) == 0
    assert [name for name, _ in drawn] == [f"{path.stem}_picks_0{n}.png" for n in (1, 2, 3)]
    whole = read_layers(tmp_path / f"out/{SEGMENT}_layers.nc")
    assert_array_equal(np.concatenate([times for _, times in drawn]), whole["slow_time"])
    (tmp_path / f"out/{path.stem}_picks_02.png").touch()
    (tmp_path / f"out/{SEGMENT}_layers.nc").unlink()
    assert track([path], png=True) == 1  # a picture is there


def test_a_picture_that_cannot_be_drawn_stops_no_file(track, tmp_path, frame, lines, monkeypatch):
    paths = [write_frame(tmp_path, frame[0], number) for number in (1, 2)]
    monkeypatch.setattr("snowsim.io.pictures.write_picture", lambda *_: {}["no such axis"])
    assert track(paths, png=True) == len(paths)
    assert "picks.png: picture: expected layers that can be drawn, found KeyError" in lines[-1]
    assert read_layers(tmp_path / "out" / f"{SEGMENT}_layers.nc").sizes["layer"] > 1


def test_the_command_tracks_and_tells_by_its_exit_code(weights, tmp_path, dataset, capsys):
    path = tmp_path / "frame.nc"
    dataset.to_netcdf(path)
    arguments = ["track", str(path), "-o", str(tmp_path / "out"), "--model", str(weights)]
    main(arguments)
    said = capsys.readouterr()
    assert f"{tmp_path / 'out' / '20120330_01_layers.nc'}: 4 layers below the surface" in said.out
    # Without a segment in its name, the day is one.
    assert (tmp_path / "out/CSARP_layer/20120330_01/Data_20120330_01_001.mat").is_file()
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    assert stopped.value.code == 1
    assert "error: " in capsys.readouterr().err


def test_a_pipe_is_refused_because_files_are_read_more_than_once(track, tmp_path, lines):
    os.mkfifo(tmp_path / "pipe")
    assert track([tmp_path / "pipe"]) == 1
    [line] = lines
    assert line.endswith("pipe: file: expected one that can be read more than once, found a pipe")


def test_a_range_bin_without_an_image_is_refused(track, tmp_path, frame):
    path = write_frame(tmp_path, frame[0])
    with refusal("bin_s: expected an image among the files, whose range bin it is, found echo"):
        track([path], bin_s=1e-10)
