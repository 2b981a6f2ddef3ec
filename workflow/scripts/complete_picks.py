"""Complete the picks of observed train scenes, by the tracker that comes with the package."""

import numpy as np
from job import checkout_files, job, progress

from lib.completed_picks import completed
from snowsim.io.models import read_tracker
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.tracker import checked_card, rows_in_image, runner

with job(snakemake) as log:
    path, _ = checkout_files(snakemake.params.tracker)
    weights, content = read_tracker(path)
    card = checked_card(content, path)
    for line in card.outside({"bin_s": snakemake.params.bin_s}):
        msg = f"cgan.picks: completed: {line}; use cgan.picks: as_picked"
        raise ValueError(msg)
    run = runner(weights, card.temperature)
    n_new = []

    def marked(scene):
        """The scene with the layers that its picks lack."""
        with_found = completed(scene, rows_in_image(run, scene.image, card))
        n_picked = np.isfinite(scene.layer_bins).any(axis=1).sum()
        n_new.append(len(with_found.layer_bins) - n_picked)
        return with_found

    with SceneSet(snakemake.input.scenes) as observed:
        scenes = map(marked, progress(observed, "picks"))
        write_scenes(snakemake.output.completed, scenes, {"synthetic": snakemake.params.source})
        log.info("%d pieces of layers in %d scenes were not picked", sum(n_new), len(observed))
