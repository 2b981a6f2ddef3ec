"""Figures of the trackers: scores of all; the first replicas on a scene of median layers."""

from main_path import job

from evaluation.lib.figures import tracker
from evaluation.lib.figures.style import TRAINING_SETS, Scale, save_figure
from lib.tracker_scores import read_tracker
from snowsim.io.files import read_dataset, read_table
from snowsim.io.scenes import SceneSet
from snowsim.tracker import pick_layers

with job(snakemake):
    files = snakemake.input
    figures = snakemake.output
    params = snakemake.params
    with SceneSet(files.scenes) as scenes:
        by_layers = sorted(scenes, key=lambda scene: len(scene.layer_bins))
    scene = by_layers[len(by_layers) // 2]
    picked = {}
    replicas = zip(TRAINING_SETS, files.networks, files.picks, strict=True)
    for name, network, rows in replicas:
        *_, fused = read_tracker(network, params.device).track(scene.image)
        threshold = read_table(rows)["threshold"].iloc[0]
        picked[name] = pick_layers(fused, threshold=threshold)
    scale = Scale.of(read_dataset(files.statistics), params.snow_density_kg_m3)
    curves = tracker.precision_recall(read_table(files.precision_recall))
    save_figure(figures.precision_recall_svg, curves, params.source)
    picks = tracker.picks(scene, picked, read_table(files.picks_by_depth), scale)
    save_figure(figures.picks_svg, picks, params.source)
