"""Table II and SSIM against depth from the per-image scores."""

import pandas as pd
from job import job

from snowsim.io.files import read_table, write_table
from snowsim.metrics.tables import similarity_table, ssim_against_depth


def tabulate(paths_to_images, paths_to_rows, path_to_images, path_to_table2, path_to_ssim_depth, window_rows):
    images = pd.concat([read_table(path) for path in paths_to_images])
    rows = pd.concat([read_table(path) for path in paths_to_rows])
    write_table(path_to_images, images)
    write_table(path_to_table2, similarity_table(images))
    write_table(path_to_ssim_depth, ssim_against_depth(rows, window_rows))


if __name__ == "__main__":
    with job(snakemake):
        tabulate(snakemake.input.images, snakemake.input.rows, *snakemake.output, **snakemake.params)
