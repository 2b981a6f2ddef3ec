"""Table II and SSIM against depth from the per-image scores."""

import pandas as pd
from job import run

from lib.score_tables import similarity_table, ssim_against_depth
from snowsim.io.files import read_table, write_table


def tabulate(images, rows, all_images, table2, ssim_depth, *, window_rows):
    scores = pd.concat([read_table(path) for path in images])
    write_table(all_images, scores)
    write_table(table2, similarity_table(scores))
    by_row = pd.concat([read_table(path) for path in rows])
    write_table(ssim_depth, ssim_against_depth(by_row, window_rows))


run(tabulate)
