"""The table of frames: what is checked before a file is opened, and after; one frame at a time."""

import re
import shutil
import warnings

import formats
import numpy as np
import pandas as pd
import pytest
from formats import failures
from numpy.testing import assert_allclose
from refusals import refusal

from snowsim.alignment import bin_size_s, layer_bins_of
from snowsim.io import check_frames, read_frame, read_frames
from snowsim.io.layers import write_layers

LAYERS = formats.LAYERS_FILE


@pytest.fixture
def flight(tmp_path, content):
    """Three frames of three formats with layers beside them, and their table."""
    formats.write_nsidc(tmp_path / "a.nc", content)
    formats.write_mat5(tmp_path / "b.mat", content)
    formats.write_mat73(tmp_path / "c.mat", content | {"Data": 1.001 * content["Data"]})
    roles = {"one": ("a.nc", "statistics"), "two": ("b.mat", "train"), "three": ("c.mat", "test")}
    formats.write_flight(tmp_path, content, roles)
    return tmp_path


def test_a_table_gives_every_frame_level_at_the_bin_size_asked_for_and_checked_its_sizes(table):
    assert table["frame"].tolist() == ["one", "two", "three"]
    for factor in (1, 3):  # not 2: a time read 1 ns earlier would tip halves of bins
        for row in table.itertuples():
            echogram, layers = read_frame(row, bin_s=factor * formats.BIN_S)
            assert_allclose(bin_size_s(echogram), factor * formats.BIN_S, rtol=1e-9)
            bins = layer_bins_of(layers, echogram)
            # The surface is stepped by whole bins, so levelling leaves nothing of it.
            assert np.ptp(bins[0]) < 1 - 1 / factor + 1e-6
            assert_allclose(bins[1] - bins[0], 40 / factor, atol=1e-6)
    checked = check_frames(table)
    assert (checked[["n_range_lines", "n_layers"]] == [formats.N_LINES, 2]).all(axis=None)
    assert_allclose(checked["bin_size_s"], formats.BIN_S, rtol=1e-9)


def test_rows_that_fail_are_named_together_before_a_file_is_opened(flight):
    (flight / "again.nc").symlink_to(flight / "a.nc")
    once = "echogram: expected once for a role, and for test or validation alone, found"
    rows = {
        "one\ta.nc\tnowhere.mat\ttrain": "layers: expected a file, found nothing at",
        # An echogram is one frame whatever its path.
        f"two\tagain.nc\t{LAYERS}\ttest": once,
        f"three\tb.mat\t{LAYERS}\tholdout": "role: expected statistics, .* found holdout",
        f"four\t\t{LAYERS}\ttrain": "echogram: expected a file, found nothing at none",
        f"five\tc.mat\t{LAYERS}\ttrain": "frame: expected names that differ",
        f"five\t../{flight.name}/c.mat\t{LAYERS}\ttrain": "frame: expected names that differ",
        f"a/six\tc.mat\t{LAYERS}\tstatistics": "frame: expected a plain file name",
        f"seven\tc.mat\t{LAYERS}\ttrain": once,
    }
    (flight / "bad.tsv").write_text("\n".join([formats.TABLE_HEADER, *rows]))
    lines = failures(lambda: read_frames(flight / "bad.tsv"), len(rows), len(rows))
    for line, (row, message) in zip(lines, rows.items(), strict=True):
        assert re.match(f"{row.partition(chr(9))[0]}: {message}", line)


ROW = f"one\ta.nc\t{LAYERS}\ttrain"
TABLES = {
    "no role": "frame\techogram\tlayers\n",
    "another column": f"{formats.TABLE_HEADER}s\n{ROW}\n",
    "no row": formats.TABLE_HEADER,
    "a longer row": f"{formats.TABLE_HEADER}\n{ROW}\tanother\n",
    "nothing": "",
}


@pytest.mark.parametrize("text", TABLES.values(), ids=TABLES)
def test_a_table_needs_its_columns_and_rows_of_as_many_fields(tmp_path, text):
    (tmp_path / "frames.tsv").write_text(text)
    with refusal(r"frames.tsv: (columns|table): expected"):
        read_frames(tmp_path / "frames.tsv")


def test_frames_of_another_bin_size_or_source_and_names_that_none_has_are_named(
    flight, table, content
):
    first = content["Time"][0]
    content["Time"] = first + (content["Time"] - first) * 1.5
    formats.write_mat73(flight / "c.mat", content)
    (line,) = failures(lambda: check_frames(table), 1, 3)
    assert line == "three: bin size: expected 2.886e-10 s as in most, found 4.329e-10 s"
    check_frames(table, bin_s=5e-10)
    lines = failures(lambda: check_frames(table, source="nsidc"), 2, 3)
    assert [line.split(":")[0] for line in lines] == ["two", "three"]
    assert lines[0].endswith("expected an IRSNO1B echogram, found a CReSIS L1B echogram")
    names = ["surface", "Koenig_2", "Koenig_3"]
    with pytest.raises(
        ValueError, match=r"^frames: 1 of 3 layer_names are in no frame\nKoenig_3: "
    ):
        check_frames(table, layer_names=names, bin_s=5e-10)


def test_named_layers_have_the_same_row_in_every_frame(rows):
    names = ["surface", "Koenig_1", "Koenig_2"]
    echogram, layers = read_frame(rows[0], layer_names=names)
    bins = layer_bins_of(layers, echogram)
    assert layers["layer"].values.tolist() == names
    assert np.isnan(bins[1]).all()
    assert_allclose(bins[2] - bins[0], 40, atol=1e-6)
    with refusal("in the order of layer_names: twtt: layers must increase strictly with depth"):
        read_frame(rows[0], layer_names=names[::-1])


def test_a_copy_of_a_frame_that_is_held_out_or_of_the_same_role_is_refused(flight):
    shutil.copy(flight / "a.nc", flight / "copy.nc")
    table = read_frames(flight / "frames.tsv")
    copied = table.iloc[[0]].assign(frame="four", echogram=str(flight / "copy.nc"), role="test")
    of_statistics = pd.concat([table.iloc[[0]], copied])
    (line,) = failures(lambda: check_frames(of_statistics), 1, 2)
    assert re.match("four: .*copy.nc: Data: expected power unlike .* found a copy of .*a.nc", line)
    assert len(check_frames(of_statistics.assign(role=["statistics", "train"]))) == 2
    failures(lambda: check_frames(of_statistics.assign(role="statistics")), 1, 2)


def test_layers_of_another_segment_are_warned_of(flight, rows):
    _, layers = read_frame(rows[0])
    for name in ("layer_20120330_05_001.nc", "layer_20120330_04_001.nc"):
        write_layers(flight / name, layers[["twtt", "quality", "type"]])
    shutil.copy(rows[0].echogram, flight / "Data_20120330_04_001.nc")
    row = rows[0]._replace(echogram=flight / "Data_20120330_04_001.nc")
    with pytest.warns(UserWarning, match="are of segment 20120330_05, the echogram is of 20120330"):
        read_frame(row._replace(layers=flight / "layer_20120330_05_001.nc"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_frame(row._replace(layers=flight / "layer_20120330_04_001.nc"))


def test_layers_of_other_names_at_one_place_are_warned_of(flight, rows):
    echogram, layers = read_frame(rows[0])
    renamed = layers.assign_coords(layer=["surface", "Koenig_1"])[["twtt", "quality", "type"]]
    write_layers(flight / "renamed.nc", renamed)
    table = read_frames(flight / "frames.tsv").iloc[:2].copy()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_frames(table)
    table.loc[table.index[1], "layers"] = str(flight / "renamed.nc")
    with pytest.warns(UserWarning, match="layer 1 is .* in one and Koenig_1 in two: statistics"):
        check_frames(table)


def test_frames_that_give_no_scene_are_named_with_the_others(flight, rng):
    content = formats.truth(rng, n_bins=400, n_lines=520)
    layers = formats.layer_content([content["Surface"]], [9], content["GPS_time"])
    formats.write_mat5(flight / LAYERS, layers)
    # One has rows above the surface for blocks, but both are flagged; one begins 30 rows above it;
    # one is narrower than a block.
    formats.write_nsidc(flight / "a.nc", formats.truth(rng, n_bins=400, n_lines=520, n_above=40))
    formats.write_mat5(flight / "b.mat", content)
    table = read_frames(flight / "frames.tsv").assign(role=["train", "train", "test"])
    flags = (np.arange(520) == 252).astype(np.uint8)
    formats.write_supplement(flight / "a_supplement.nc", no_good_data=flags)
    one, two, three = failures(lambda: check_frames(table, blocks=True), 3, 3)
    assert "found none in 520 range lines (one_000: 1 of 256 range lines flagged" in one
    assert "at least one that is a scene, found none in 520 range lines (two_000: rows -" in two
    assert "found none in 40 range lines (a block has 256)" in three


def test_a_surface_far_from_the_echograms_or_without_a_name_is_told_of(flight, rows, content):
    content["Surface"] = content["Surface"] - 30 * formats.BIN_S
    formats.write_mat5(flight / "b.mat", content)
    with pytest.warns(UserWarning, match="layer 0 lies 30 range bins from the echogram's Surface"):
        read_frame(rows[1])
    (flight / formats.ORGANIZER_FILE).unlink()
    with refusal("layer: expected one named surface .*, found id 9, id 5"):
        read_frame(rows[0])


@pytest.mark.parametrize("n_lines", [formats.N_LINES, 700], ids=["short", "long"])
@pytest.mark.parametrize("reach", [0, 1], ids=["fit", "reach over"])
def test_layers_of_gps_time_are_named_as_such(flight, rows, rng, n_lines, reach):
    # Lines of .0537 s: no whole number of them is 15 s.
    own_s = formats.GPS_START + 0.0537 * np.arange(n_lines)
    content = formats.truth(rng, n_lines=n_lines) | {"GPS_time": own_s}
    formats.write_mat5(flight / "b.mat", content)
    gps_time = own_s[0] + 0.0537 * np.arange(-reach * n_lines, (1 + reach) * n_lines)
    surface = formats.truth(rng, n_lines=gps_time.size)["Surface"]
    for late_s, order in ((15, "later"), (-15, "earlier"), (0, None)):
        stored = formats.layer_content([surface], [9], gps_time + late_s)
        formats.write_mat5(flight / LAYERS, stored)
        if order is not None:
            with refusal(f"found times 15 s {order} than its own: is one of both GPS time"):
                read_frame(rows[1])
    assert read_frame(rows[1])[1].sizes["slow_time"] == n_lines


def test_layers_of_gps_time_are_named_where_no_line_has_the_time_of_another(flight, rows, rng):
    # Lines of .0537 s, those of the layers 5 ms later: at GPS time 22 of 37 s overlap.
    own_s = formats.GPS_START + 0.0537 * np.arange(700)
    formats.write_mat5(flight / "b.mat", formats.truth(rng, n_lines=700) | {"GPS_time": own_s})
    surface = formats.truth(rng, n_lines=700)["Surface"]
    stored = formats.layer_content([surface], [9], own_s + 15.005)
    formats.write_mat5(flight / LAYERS, stored)
    with refusal("found times 15 s later than its own: is one of both GPS time"):
        read_frame(rows[1])
