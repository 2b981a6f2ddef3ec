"""One convention of PHY through the closed loop: renders of a part of the label sets, and their statistics."""

from estimate_closed_loop import estimate_loop
from job import job
from render_closed_loop import summarise_part

from snowsim.io.files import read_dataset


def try_convention(paths_to_layers, path_to_statistics, path_to_recovered, path_to_table, **options):
    given = read_dataset(path_to_statistics)
    estimate_loop(summarise_part(paths_to_layers, given, **options), given, path_to_recovered, path_to_table)


if __name__ == "__main__":
    with job(snakemake):
        try_convention(snakemake.input.layers, snakemake.input.statistics, *snakemake.output, **snakemake.params)
