"""Complete the picks of observed train scenes, by the tracker that comes with the package."""

import numpy as np
from job import job, progress
from scipy.special import expit

from snowsim.cgan.picks import completed
from snowsim.io.models import read_tracker
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.tracker import fused_logits, network_of_onnx, pick_layers

with job(snakemake) as log:
    content, card = read_tracker(snakemake.input.weights)
    least, most = card["ranges"]["bin_s"]
    bin_s = snakemake.params.bin_s
    if not least <= bin_s <= most:
        msg = f"cgan.picks: completed: the tracker knows range bins of {least:g} to {most:g} s, "
        msg += f"got {bin_s:g}; use cgan.picks: as_picked"
        raise ValueError(msg)
    network = network_of_onnx(content)
    n_new = []

    def marked(scene):
        """The scene with the layers that its picks lack."""
        probability = expit(fused_logits(network, scene.image) / card["temperature"])
        found = pick_layers(probability, threshold=card["threshold"], where=scene.name)
        with_found = completed(scene, found)
        n_picked = np.isfinite(scene.layer_bins).any(axis=1).sum()
        n_new.append(len(with_found.layer_bins) - n_picked)
        return with_found

    with SceneSet(snakemake.input.scenes) as observed:
        scenes = map(marked, progress(observed, "picks"))
        write_scenes(snakemake.output.completed, scenes, {"synthetic": snakemake.params.source})
        log.info("%d pieces of layers in %d scenes were not picked", sum(n_new), len(observed))
