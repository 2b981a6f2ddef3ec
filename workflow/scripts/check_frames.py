"""Read every frame of the table before anything is computed from one; report all that fail."""

from job import job

from snowsim.io.files import write_table
from snowsim.io.frames import check_frames, read_frames

with job(snakemake) as log:
    frames = read_frames(snakemake.input.frames)
    checked = check_frames(frames, blocks=True, **snakemake.params.reading)
    flagged = checked[checked["flags"] != ""]
    for row in flagged.itertuples():
        lines = f"{row.n_flagged_lines} of {row.n_range_lines} range lines left out"
        blocks = f"{row.n_flagged_blocks} blocks skipped for them"
        log.info("%s: %s, %s; flags: %s", row.frame, lines, blocks, row.flags)
    # Files by name: results must not depend on where the data lie.
    write_table(snakemake.output.table, checked.drop(columns=["echogram", "layers"]))
