"""Where the tracker fails: rates, seeds, brightness, odd heights, few and many layers, labels and images of nothing."""

import dataclasses

import numpy as np
import pandas as pd
import torch
from job import job, progress

from snowsim.echogram import SURFACE_ROW, layer_mask, scene_height, to_uint8
from snowsim.io.files import read_dataset, write_table
from snowsim.io.models import read_model
from snowsim.io.scenes import SceneSet
from snowsim.metrics.edges import THRESHOLDS, match_counts, score, suppress
from snowsim.phy import draw_parameters, plan, render_plan
from snowsim.seeding import random_stream
from snowsim.tracker import Settings, Training, TrainingSet, track, train_steps, trained_network

LAYER_SPACING_BINS = 12
N_LAST = 50  # steps whose loss is averaged: what a training has come to


def fused_ods(network, precision, scenes):
    """ODS of the fused output on (image, mask) pairs."""
    counts = [
        match_counts(suppress(track(network, image, precision=precision)[5]), mask, THRESHOLDS)
        for image, mask in scenes
    ]
    return score(counts)["ods"]


def short_training(real, settings, seed):
    """Mean loss of the last steps of a short training, or what ended it."""
    try:
        losses = [step["total"] for _, step in train_steps(Training(settings, seed=seed), TrainingSet(real, seed=seed))]
    except FloatingPointError:
        return np.nan, "diverged"
    return float(np.mean(losses[-N_LAST:])), "ok"


def outcome(work):
    """Value of work, or NaN and `refused` where a ValueError says why it cannot be done."""
    try:
        return work(), "ok"
    except ValueError:
        return np.nan, "refused"


def level_scene(n_layers, statistics, phy, rng, n_range_lines=256):
    """Image and mask of level layers, rendered by PHY."""
    layer_bins = SURFACE_ROW + LAYER_SPACING_BINS * np.arange(n_layers + 1.0)[:, None] * np.ones(n_range_lines)
    drawn = {key: phy[key] for key in ("width", "n_looks", "speckle_correlation")}
    parameters = draw_parameters(statistics, n_layers + 1, **drawn, rng=rng)
    options = {key: phy[key] for key in ("tolerance_db", "speckle", "normalise", "align")}
    n_range_bins = scene_height(layer_bins)
    power = render_plan(plan(layer_bins, parameters, n_range_bins, **options), rng=rng)
    return to_uint8(power)[0], layer_mask(layer_bins, n_range_bins)


def stress(
    paths_to_train, paths_to_scenes, path_to_network, path_to_statistics, path_to_table, seed, settings, phy, stability
):
    torch.set_num_threads(1)
    rows = []

    def add(panel, value, replica, result, status):
        rows.append({"panel": panel, "value": value, "replica": replica, "result": result, "status": status})

    with SceneSet(paths_to_train) as real, SceneSet(paths_to_scenes) as held_out:
        for rate in progress(stability["learning_rates"], "learning rates"):
            changed = Settings(**{**settings, "n_steps": stability["n_steps"], "learning_rate": rate})
            for replica in range(stability["n_seeds"]):
                add("loss", rate, replica, *short_training(real, changed, replica))
        empty = dataclasses.replace(real[0], layer_bins=np.full_like(real[0].layer_bins, np.nan))
        add("empty labels", 0, 0, *outcome(lambda: short_training([empty], changed, 0)[0]))
        scenes = [(scene.image, scene.mask()) for scene in held_out]
    weights, metadata = read_model(path_to_network, {"kind": "tracker"})
    trained = Settings(**metadata["settings"])
    network = trained_network(weights, trained)
    add("flat image", 0, 0, *outcome(lambda: fused_ods(network, trained.precision, [(scenes[0][0] * 0, scenes[0][1])])))
    for shift in progress(stability["brightness_shifts"], "brightness"):
        shifted = [(np.clip(image.astype(int) + shift, 0, 255).astype(np.uint8), mask) for image, mask in scenes]
        add("brightness", shift, 0, *outcome(lambda pairs=shifted: fused_ods(network, trained.precision, pairs)))
    for cut in progress(stability["rows_cut"], "heights"):
        # From the bottom, where no layer lies.
        heights = [image.shape[0] // 16 * 16 - cut for image, _ in scenes]
        pairs = [(image[:rows], mask[:rows]) for (image, mask), rows in zip(scenes, heights, strict=True)]
        add("rows cut", cut, 0, *outcome(lambda pairs=pairs: fused_ods(network, trained.precision, pairs)))
    statistics = read_dataset(path_to_statistics)
    for n_layers in progress(stability["n_layers"], "layers"):
        rng = random_stream(seed, "stress_tracker", n_layers)
        pairs = [level_scene(n_layers, statistics, phy, rng)]
        add("layers", n_layers, 0, *outcome(lambda pairs=pairs: fused_ods(network, trained.precision, pairs)))
    write_table(path_to_table, pd.DataFrame(rows))


if __name__ == "__main__":
    with job(snakemake):
        stress(
            snakemake.input.train,
            snakemake.input.scenes,
            snakemake.input.network,
            snakemake.input.statistics,
            *snakemake.output,
            **snakemake.params,
        )
