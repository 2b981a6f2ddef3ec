"""Fused edge scores of every setting of the ablation against the default of the same training set."""

from job import job

from snowsim.io.files import read_table, write_table
from snowsim.metrics.comparison import compare
from snowsim.metrics.tables import counts_by_image
from snowsim.seeding import random_stream


def tabulate(paths_to_counts, path_to_table, runs, replicas, n_bootstrap, seed):
    runs = [tuple(run) for run in runs]
    paths = iter(paths_to_counts)
    counts = {run: [counts_by_image(read_table(next(paths))) for _ in replicas] for run in runs}
    # The defaults against RD's, every other setting against the default.
    pairs = [
        ((setting, training_set), ("default", "rd" if setting == "default" else training_set))
        for setting, training_set in runs
    ]
    table = compare(counts, pairs, n_bootstrap=n_bootstrap, rng=random_stream(seed, "tabulate_ablation"))
    for column in ("base", "name"):
        table.insert(0, f"{column}_training_set", [run[1] for run in table[column]])
        table[column] = [run[0] for run in table[column]]
    names = {"name": "setting", "name_training_set": "training_set"}
    table = table.rename(columns=names)
    first = ["setting", "training_set", "base", "base_training_set"]
    write_table(path_to_table, table[first + [column for column in table.columns if column not in first]])


if __name__ == "__main__":
    with job(snakemake):
        tabulate(snakemake.input.counts, snakemake.output.table, **snakemake.params)
