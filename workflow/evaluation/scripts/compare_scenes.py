"""Observed train scenes beside label sets as PHY and cGAN render them."""

from functools import partial
from itertools import islice

import numpy as np
from main_path import progress, run

from evaluation.lib.drawn_scenes import (
    describe_image,
    describe_layers,
    scenes_table,
    span_of,
    two_sample_table,
)
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream


def compare_scenes(observed, phy, cgan, two_sample, numbers, *, n_scenes, n_splits, n_steps, seed):
    stream = partial(random_stream, seed, "compare_scenes")
    sets = {}
    for name, paths in {"observed": observed, "phy": phy, "cgan": cgan}.items():
        with SceneSet(paths) as scenes:
            sets[name] = list(islice(scenes, n_scenes))
    n = min(map(len, sets.values()))
    sets = {name: scenes[:n] for name, scenes in sets.items()}
    table = two_sample_table(sets, n_splits=n_splits, n_steps=n_steps, stream=stream)
    write_table(two_sample, table)

    spans = {name: [span_of(scene) for scene in scenes] for name, scenes in sets.items()}
    # A render by the cGAN, which has learned grey levels alone, has as many decibels as observed
    # scenes in the mean.
    spans["cgan"] = [np.mean(spans["observed"])] * n
    found = {}
    for name, scenes in sets.items():
        with_span = progress(zip(scenes, spans[name], strict=True), name, total=n)
        found[name] = [describe_image(scene, span) for scene, span in with_span]
    # Both renders are of the same layers.
    for name in ("observed", "phy"):
        for scene, of_scene in zip(sets[name], found[name], strict=True):
            layer_bins = scene.complete_layer_bins
            if layer_bins is None:
                layer_bins = scene.layer_bins
            of_scene |= describe_layers(layer_bins)
    write_table(numbers, scenes_table(found, rng=stream("numbers")))


run(compare_scenes)
