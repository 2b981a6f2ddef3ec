"""The table of frames: what is checked before a file is opened, and after; one frame in memory at a time."""

from types import SimpleNamespace

import formats
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from snowsim.echogram import bin_size_s, layer_bins_of
from snowsim.io.frame_table import check_frames, each_frame, read_frame, read_frames

HEADER = "frame\techogram\tlayers\trole\n"


@pytest.fixture
def flight(tmp_path, rng):
    """Three frames of three formats with layers beside them, and their table."""
    content = formats.truth(rng)
    formats.write_nsidc(tmp_path / "a.nc", content)
    formats.write_mat5(tmp_path / "b.mat", content)
    formats.write_mat73(tmp_path / "c.mat", content)
    surface = content["Surface"]
    layers = formats.layer_content([surface + 40 * formats.BIN_S, surface], [5, 9], content["GPS_time"])
    formats.write_mat5(tmp_path / "Data_20120330_04_001.mat", layers)
    formats.write_mat5(tmp_path / "layer_20120330_04.mat", formats.organizer_content([5, 9], ["Koenig_2", "surface"]))
    (tmp_path / "frames.tsv").write_text(
        "# a remark\n"
        + HEADER
        + "".join(
            f"{name}\t{file}\tData_20120330_04_001.mat\t{role}\n"
            for name, file, role in (
                ("one", "a.nc", "statistics"),
                ("two", "b.mat", "train"),
                ("three", "c.mat", "test"),
            )
        )
    )
    return tmp_path


def test_a_table_gives_every_frame_level_and_with_the_surface_first(flight):
    table = read_frames(flight / "frames.tsv")
    assert table["frame"].tolist() == ["one", "two", "three"]
    for echogram, layers in each_frame(table):
        bins = layer_bins_of(layers, echogram)
        # The surface is stepped by whole bins, so levelling leaves nothing of it.
        assert np.ptp(bins[0]) < 1e-6
        assert_allclose(bins[1] - bins[0], 40, atol=1e-6)
        rows = np.nanargmax(echogram["Data"].values, axis=0)
        assert_allclose(rows, bins[0], atol=1e-6)


def test_roles_choose_frames(flight):
    table = read_frames(flight / "frames.tsv")
    assert len(list(each_frame(table, "train"))) == 1


def test_frames_come_at_one_bin_size(flight):
    table = read_frames(flight / "frames.tsv")
    for echogram, layers in each_frame(table, bin_s=2 * formats.BIN_S):
        assert_allclose(bin_size_s(echogram), 2 * formats.BIN_S, rtol=1e-9)
        bins = layer_bins_of(layers, echogram)
        assert_allclose(bins[1] - bins[0], 20, atol=1e-6)


def test_checked_frames_tell_their_sizes(flight):
    checked = check_frames(read_frames(flight / "frames.tsv"))
    assert checked["n_range_lines"].tolist() == [formats.N_LINES] * 3
    assert checked["n_layers"].tolist() == [2] * 3
    assert_allclose(checked["bin_size_s"], formats.BIN_S, rtol=1e-9)


def test_rows_that_fail_are_told_together_before_a_file_is_opened(flight):
    (flight / "bad.tsv").write_text(
        HEADER
        + "one\ta.nc\tnowhere.mat\ttrain\n"
        + "two\ta.nc\tData_20120330_04_001.mat\ttest\n"
        + "three\tb.mat\tData_20120330_04_001.mat\tholdout\n"
        + "four\t\tData_20120330_04_001.mat\ttrain\n"
        + "five\tc.mat\tData_20120330_04_001.mat\ttrain\n"
        + "five\tb.mat\tData_20120330_04_001.mat\ttrain\n"
    )
    with pytest.raises(ValueError, match="6 of 6 frames fail") as error:
        read_frames(flight / "bad.tsv")
    lines = str(error.value).splitlines()
    assert len(lines) == 7
    for line, message in zip(
        lines[1:],
        (
            "one: layers: expected a file, found nothing at",
            "two: echogram: expected a test frame to have no other role, found test and train",
            "three: role: expected statistics, train, validation, test, found holdout",
            "four: echogram: expected a value, found none",
            "five: frame: expected names that differ",
            "five: frame: expected names that differ",
        ),
        strict=True,
    ):
        assert message in line


def test_files_that_fail_are_told_together(flight):
    whole = (flight / "a.nc").read_bytes()
    (flight / "a.nc").write_bytes(whole[: len(whole) // 2])
    (flight / "c.mat").write_bytes(b"nothing")
    table = read_frames(flight / "frames.tsv")
    with pytest.raises(ValueError, match="2 of 3 frames fail") as error:
        check_frames(table)
    assert [line.split(":")[0] for line in str(error.value).splitlines()[1:]] == ["one", "three"]


def test_frames_of_another_bin_size_are_told(flight, rng):
    content = formats.truth(rng)
    content["Time"] = content["Time"][0] + (content["Time"] - content["Time"][0]) * 1.5
    formats.write_mat73(flight / "c.mat", content)
    table = read_frames(flight / "frames.tsv")
    with pytest.raises(ValueError, match="three: bin size: expected 2.886e-10 s as in most, found 4.329e-10 s"):
        check_frames(table)
    check_frames(table, bin_s=5e-10)


def test_named_layers_have_the_same_row_in_every_frame(flight):
    row = next(read_frames(flight / "frames.tsv").itertuples())
    names = ["surface", "Koenig_1", "Koenig_2"]
    echogram, layers = read_frame(row, layer_names=names)
    bins = layer_bins_of(layers, echogram)
    assert layers["layer"].values.tolist() == names
    assert np.isnan(bins[1]).all()
    assert_allclose(bins[2] - bins[0], 40, atol=1e-6)


def test_names_that_no_frame_has_are_told(flight):
    table = read_frames(flight / "frames.tsv")
    with pytest.raises(
        ValueError, match="Koenig_3: layer_names: expected layers that some frame has, found it in none"
    ):
        check_frames(table, layer_names=["surface", "Koenig_2", "Koenig_3"])


def test_frames_of_another_source_are_told(flight):
    table = read_frames(flight / "frames.tsv")
    with pytest.raises(ValueError, match="2 of 3 frames fail") as error:
        check_frames(table, source="nsidc")
    for line, name in zip(str(error.value).splitlines()[1:], ("two", "three"), strict=True):
        assert line.startswith(f"{name}: ")
        assert line.endswith("format: expected an IRSNO1B echogram, found a CReSIS L1B echogram")


def test_frames_that_give_no_scene_are_told_with_the_others(flight, rng):
    content = formats.truth(rng, n_bins=400, n_lines=520)
    layers = formats.layer_content([content["Surface"]], [9], content["GPS_time"])
    formats.write_mat5(flight / "Data_20120330_04_001.mat", layers)
    # One has rows above the surface for blocks, one begins 30 rows above it, one is narrower than a block.
    above = formats.BIN_S * np.arange(-40, 0) + content["Time"][0]
    air = np.full((40, 520), 1e-3, dtype=np.float32)
    whole = content | {"Data": np.vstack([air, content["Data"]]), "Time": np.concatenate([above, content["Time"]])}
    formats.write_nsidc(flight / "a.nc", whole)
    formats.write_mat5(flight / "b.mat", content)
    formats.write_mat73(flight / "c.mat", {k: v[..., :200] if k != "Time" else v for k, v in content.items()})
    table = read_frames(flight / "frames.tsv").assign(role=["train", "train", "test"])
    with pytest.raises(ValueError, match="2 of 3 frames fail") as error:
        check_frames(table, blocks=True)
    two, three = str(error.value).splitlines()[1:]
    assert "blocks: expected at least one that is a scene, found none (two_000: rows -" in two
    assert "a block has 256 range lines, the frame only 200" in three
    checked = check_frames(table[:1], blocks=True)
    assert checked["n_scenes"].tolist() == [2]
    assert checked["n_skipped"].tolist() == [0]


@pytest.mark.parametrize("text", ["frame\techogram\tlayers\n", HEADER.replace("role", "roles"), "", HEADER])
def test_a_table_needs_its_columns_and_a_row(tmp_path, text):
    (tmp_path / "frames.tsv").write_text(text)
    with pytest.raises(ValueError, match=r"frames.tsv: (columns|frames|table): expected"):
        read_frames(tmp_path / "frames.tsv")


def test_without_a_layer_named_surface_a_frame_is_refused(flight):
    (flight / "layer_20120330_04.mat").unlink()
    row = SimpleNamespace(echogram=flight / "a.nc", layers=flight / "Data_20120330_04_001.mat")
    with pytest.raises(ValueError, match="layer: expected one named surface .*, found id 9, id 5"):
        read_frame(row)


def test_layers_that_end_early_are_refused_with_the_file(flight, rng):
    content = formats.truth(rng)
    layers = formats.layer_content(content["Surface"][None, :30], [9], content["GPS_time"][:30])
    formats.write_mat5(flight / "Data_20120330_04_001.mat", layers)
    row = SimpleNamespace(echogram=flight / "a.nc", layers=flight / "Data_20120330_04_001.mat")
    with pytest.raises(ValueError, match="Data_20120330_04_001.mat: slow_time: expected to cover"):
        read_frame(row)


def test_compensated_files_give_the_frame_of_the_plain_ones(flight, rng):
    content = formats.truth(rng)
    stored = formats.compensated(content, np.arange(formats.N_LINES) % 7, n_kept=formats.N_BINS)
    formats.write_mat73(flight / "c.mat", stored)
    plain, compensated = (
        read_frame(SimpleNamespace(echogram=flight / name, layers=flight / "Data_20120330_04_001.mat"))
        for name in ("b.mat", "c.mat")
    )
    found = np.isfinite(compensated[0]["Data"].values)
    brightest = [f[0]["twtt"].values[np.nanargmax(f[0]["Data"].values, axis=0)] for f in (plain, compensated)]
    assert_allclose(brightest[0], brightest[1], atol=formats.BIN_S / 100)
    assert_allclose(plain[1]["twtt"], compensated[1]["twtt"], atol=formats.BIN_S / 100)
    assert found.any()
    assert_array_equal(plain[1]["layer"], compensated[1]["layer"])
