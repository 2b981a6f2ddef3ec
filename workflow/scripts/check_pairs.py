"""Read every scene of the lists once: all that fail are told together, before anything is computed from one."""

import pandas as pd
from job import job

from snowsim.io.files import write_table
from snowsim.io.png_pairs import PairSet


def check(path_to_table, lists, data_scale, contrast_db):
    rows, failed = [], []
    for split, path in lists.items():
        try:
            rows += [{"split": split, **row} for row in PairSet(path, data_scale=data_scale).check()]
        except ValueError as error:
            failed.append(f"{path}: {error}")
    if failed:
        raise ValueError("\n".join(failed))
    table = pd.DataFrame(rows)
    mute = table[(table["split"] == "train") & ~table["tells_db"]]
    if contrast_db is None and len(mute):
        msg = (
            f"{len(mute)} train scenes, {mute['name'].iloc[0]} the first, do not tell what their grey levels stand "
            "for: import.pairs.contrast_db: expected decibels from the noise floor to 255, got null"
        )
        raise ValueError(msg)
    widths = table.groupby("split")["n_range_lines"].first()
    if widths.nunique() > 1:
        found = ", ".join(f"{split} {width}" for split, width in widths.items())
        msg = f"range lines of a scene: expected the same in all lists, found {found}"
        raise ValueError(msg)
    write_table(path_to_table, table)


if __name__ == "__main__":
    with job(snakemake):
        check(snakemake.output.table, **snakemake.params)
