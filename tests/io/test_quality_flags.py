"""Quality flags of IRSNO1B supplements: what they take out, what is counted, what is not."""

import formats
import numpy as np
import pytest
from refusals import refusal
from runs import CONFIG

from lib.configuration import read_schema
from snowsim.alignment import FLAGGED_BY
from snowsim.io import check_frames, read_frame
from snowsim.io.containers import SUPPLEMENT_FLAGS

N_LINES = 520  # blocks of 256 lines begin at 0 and 250
ROLES = ("statistics", "train", "test")


@pytest.fixture
def flight(tmp_path, rng):
    """Folder of three IRSNO1B frames, one a role and called so, with layers and a table."""
    formats.write_nsidc_flight(tmp_path, rng, ROLES, N_LINES)
    return tmp_path


def supplement(folder, number, **flags):
    """Write the supplement beside a frame: all eight flags, for the whole frame or by line."""
    path = folder / f"{ROLES[number]}_supplement.nc"
    formats.write_supplement(path, **(dict.fromkeys(SUPPLEMENT_FLAGS, 0) | flags))


def by_line(*lines):
    """A flag by range line, set on these."""
    return np.isin(np.arange(N_LINES), lines).astype(np.uint8)


def test_the_setting_knows_the_flags_of_the_files():
    described = read_schema()["properties"]["import"]["properties"]["flagged_by"]
    assert described["items"]["enum"] == list(SUPPLEMENT_FLAGS)
    assert CONFIG["import"]["flagged_by"] == list(FLAGGED_BY)


def test_lines_blocks_and_flags_are_counted_in_the_table_of_frames(flight, table):
    supplement(flight, 0, vertical_stripes_artifact=by_line(*range(40)), land_ice=1)
    supplement(flight, 1, coh_noise_removal_artifact=by_line(300), low_SNR=1)
    table = check_frames(table, blocks=True)
    columns = ["n_flagged_lines", "n_scenes", "n_skipped", "n_flagged_blocks"]
    assert table[columns].to_numpy().tolist() == [[40, 0, 0, 0], [1, 1, 1, 1], [0, 2, 0, 0]]
    flags = (
        f"vertical_stripes_artifact 40; land_ice {N_LINES}",
        f"coh_noise_removal_artifact 1; low_SNR {N_LINES}",
    )
    assert table["flags"].tolist() == [*flags, ""]


def test_frames_flagged_throughout_are_refused_by_name_all_in_one_go(flight, table):
    supplement(flight, 0, no_good_data=1)
    supplement(flight, 2, unclassified_artifact=1, land_ice=1)
    first, last = formats.failures(lambda: check_frames(table, blocks=True), 2, 3)
    ending = "quality_mask: expected a range line without a flag, found all 520 flagged"
    assert first == f"statistics: {flight}/statistics.nc: {ending} (no_good_data 520)"
    assert last == f"test: {flight}/test.nc: {ending} (unclassified_artifact 520; land_ice 520)"
    checked = check_frames(table, blocks=True, flagged_by=[])
    assert checked["n_flagged_lines"].tolist() == [0, 0, 0]


def test_an_unknown_flag_is_refused(rows):
    with refusal("flagged_by must be one of .*, got 'zero_padding'"):
        read_frame(rows[0], flagged_by=["zero_padding"])
