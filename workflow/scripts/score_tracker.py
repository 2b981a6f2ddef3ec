"""Edge counts of one tracker on the test scenes, every output, every threshold."""

import pandas as pd
import torch
from job import job, progress

from snowsim.io.files import write_table
from snowsim.io.models import read_model
from snowsim.io.scenes import SceneSet
from snowsim.metrics.edges import THRESHOLDS, match_counts, suppress
from snowsim.tracker import OUTPUTS, Settings, track, trained_network


def score(paths_to_scenes, path_to_network, path_to_counts, device, outputs=OUTPUTS):
    torch.set_num_threads(1)
    weights, metadata = read_model(path_to_network, {"kind": "tracker"})
    settings = Settings(**metadata["settings"])
    network = trained_network(weights, settings, device=device)
    tables = []
    with SceneSet(paths_to_scenes) as scenes:
        for scene in progress(scenes, "edge scores"):
            probabilities = track(network, scene.image, precision=settings.precision)
            for output in outputs:
                probability = probabilities[OUTPUTS.index(output)]
                counts = match_counts(
                    suppress(probability, where=scene.name), scene.mask(), THRESHOLDS, where=scene.name
                )
                tables.append(pd.DataFrame({"scene": scene.name, "output": output, "threshold": THRESHOLDS, **counts}))
    write_table(path_to_counts, pd.concat(tables))


if __name__ == "__main__":
    with job(snakemake):
        score(snakemake.input.scenes, snakemake.input.network, snakemake.output.counts, **snakemake.params)
