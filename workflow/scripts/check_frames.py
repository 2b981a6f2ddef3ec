"""Read every frame of the table before anything is computed from one; report all that fail."""

from job import logger, run

from snowsim.io import frame_table
from snowsim.io.files import write_table


def check_frames(frames, table, *, reading):
    checked = frame_table.check_frames(frame_table.read_frames(frames), blocks=True, **reading)
    flagged = checked[checked["flags"] != ""]
    for row in flagged.itertuples():
        lines = f"{row.n_flagged_lines} of {row.n_range_lines} range lines left out"
        blocks = f"{row.n_flagged_blocks} blocks skipped for them"
        logger.info("%s: %s, %s; flags: %s", row.frame, lines, blocks, row.flags)
    # Files by name: results must not depend on where the data lie.
    write_table(table, checked.drop(columns=["echogram", "layers"]))


run(check_frames)
