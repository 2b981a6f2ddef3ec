"""Score renders of test scenes against the observed ones, image by image and row by row."""

import pandas as pd
from job import job, progress

from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet
from snowsim.metrics.image import similarity, ssim_map


def score_method(observed, path_to_rendered, method):
    """Two tables of one method: scores of each image, and mean SSIM of each row of each image."""
    images, rows = [], []
    with SceneSet(path_to_rendered) as rendered:
        pairs = zip(observed, rendered, strict=True)
        for truth, scene in progress(pairs, f"similarity of {method}", total=len(observed)):
            if truth.name != scene.name:
                msg = f"{path_to_rendered}: expected scene {truth.name}, got {scene.name}"
                raise ValueError(msg)
            keys = {"scene": truth.name, "method": method}
            images.append({**keys, **similarity(scene.image, truth.image)})
            ssim = ssim_map(scene.image, truth.image).mean(axis=1)
            rows.append(pd.DataFrame({**keys, "range_bin": range(ssim.size), "ssim": ssim}))
    return pd.DataFrame(images), pd.concat(rows)


with job(snakemake), SceneSet(snakemake.input.observed) as observed:
    for i, method in enumerate(snakemake.params.methods):
        images, rows = score_method(observed, snakemake.input.rendered[i], method)
        write_table(snakemake.output.images[i], images)
        write_table(snakemake.output.rows[i], rows)
