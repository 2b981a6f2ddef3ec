"""Score rendered test scenes against the observed ones, image by image and row by row."""

import pandas as pd
from job import job, progress

from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet
from snowsim.metrics.image import similarity, ssim_map


def score_shard(path_to_observed, path_to_rendered, path_to_images, path_to_rows, method):
    images, rows = [], []
    with SceneSet(path_to_observed) as observed_scenes, SceneSet(path_to_rendered) as rendered_scenes:
        pairs = zip(observed_scenes, rendered_scenes, strict=True)
        for observed, rendered in progress(pairs, "similarity", total=len(observed_scenes)):
            if observed.name != rendered.name:
                msg = f"{path_to_rendered}: expected scene {observed.name}, got {rendered.name}"
                raise ValueError(msg)
            images.append(
                {
                    "scene": observed.name,
                    "method": method,
                    **similarity(rendered.image, observed.image),
                }
            )
            ssim = ssim_map(rendered.image, observed.image).mean(axis=1)
            rows.append(
                pd.DataFrame({"scene": observed.name, "method": method, "range_bin": range(ssim.size), "ssim": ssim})
            )
    write_table(path_to_images, pd.DataFrame(images))
    write_table(path_to_rows, pd.concat(rows))


if __name__ == "__main__":
    with job(snakemake):
        score_shard(*snakemake.input[:2], *snakemake.output, method=snakemake.wildcards.method)
