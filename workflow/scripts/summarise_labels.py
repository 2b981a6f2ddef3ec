"""Tables of what was drawn beside the flight it was drawn from."""

from job import job, progress

from lib.diagnostics.label_summary import summarise_labels
from snowsim.io.files import read_dataset, write_table
from snowsim.io.scenes import SceneSet


def summarise(path_to_statistics, paths_to_labels, paths_to_tables):
    with SceneSet(paths_to_labels) as scenes:
        tables = summarise_labels(progress(scenes, "labels"), read_dataset(path_to_statistics))
    for name, path in paths_to_tables.items():
        write_table(path, tables[name])


if __name__ == "__main__":
    with job(snakemake):
        summarise(snakemake.input.statistics, snakemake.input.labels, dict(snakemake.output.items()))
