"""Table II and SSIM against depth from the per-image scores."""

import pandas as pd
from job import job

from lib.score_tables import similarity_table, ssim_against_depth
from snowsim.io.files import read_table, write_table

with job(snakemake):
    scores = pd.concat([read_table(path) for path in snakemake.input.images])
    write_table(snakemake.output.all_images, scores)
    write_table(snakemake.output.table2, similarity_table(scores))
    by_row = pd.concat([read_table(path) for path in snakemake.input.rows])
    against_depth = ssim_against_depth(by_row, snakemake.params.window_rows)
    write_table(snakemake.output.ssim_depth, against_depth)
