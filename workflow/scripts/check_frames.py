"""Read every frame of the table once: all that fail are told together, before anything is computed from one."""

from job import job

from snowsim.io.files import write_table
from snowsim.io.frame_table import check_frames, read_frames


def check(path_to_frames, path_to_table, reading, log):
    table = check_frames(read_frames(path_to_frames), blocks=True, **reading)
    for row in table[table["flags"] != ""].itertuples():
        lines, blocks = f"{row.n_unfit_lines} of {row.n_range_lines}", f"{row.n_unfit_blocks} blocks"
        log.info("%s: %s range lines left out, %s skipped for them; flags: %s", row.frame, lines, blocks, row.flags)
    # Files by name: results must not depend on where the data lie.
    write_table(path_to_table, table.drop(columns=["echogram", "layers"]))


if __name__ == "__main__":
    with job(snakemake) as logger:
        check(snakemake.input.table, snakemake.output.table, log=logger, **snakemake.params)
