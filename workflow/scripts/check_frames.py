"""Read every frame of the table once: all that fail are reported together, before anything is computed from one."""

from job import logger, run

from snowsim.io import frame_table
from snowsim.io.files import write_table


def check_frames(frames, table, *, reading):
    checked = frame_table.check_frames(frame_table.read_frames(frames), blocks=True, **reading)
    for row in checked[checked["flags"] != ""].itertuples():
        lines, blocks = (
            f"{row.n_flagged_lines} of {row.n_range_lines}",
            f"{row.n_flagged_blocks} blocks",
        )
        logger.info(
            "%s: %s range lines left out, %s skipped for them; flags: %s",
            row.frame,
            lines,
            blocks,
            row.flags,
        )
    # Files by name: results must not depend on where the data lie.
    write_table(table, checked.drop(columns=["echogram", "layers"]))


run(check_frames)
